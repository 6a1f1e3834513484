//! Decoded samples in a file with a name, which outlives the process.

use std::fs::File;
use std::path::Path;

use super::decode::{decode_into, decoded_bytes, decoded_doubles};
use super::{Access, Field, FieldError};
use crate::base::control::Control;
use crate::base::{Band, SampleType};

impl Field {
    /// Decodes a band of plain doubles into a file, in parallel, for [`Field::of_decoded`]. `folder` is where the file is, for
    /// messages.
    ///
    /// # Errors
    /// [`FieldError`]; what is in the file by then is of no use.
    ///
    /// # Panics
    /// If the band has other samples, or a mask.
    pub fn decode_into(band: &Band, file: &File, folder: &Path, control: &Control<'_>) -> Result<(), FieldError> {
        assert!(band.sample_type() == SampleType::F64 && !band.has_mask(), "plain doubles");
        let failed = |source| FieldError::Temporary { dir: folder.to_path_buf(), bytes: decoded_bytes(band), source };
        decode_into(band, file.try_clone().map_err(failed)?, folder, control)
    }

    /// The heights in a file that [`Field::decode_into`] has filled; NaN is no height. `name` is what messages call the raster.
    /// `None` where the file has another length than that of so many samples across and down. It is mapped: nobody may shorten it.
    ///
    /// # Errors
    /// [`FieldError::Map`].
    pub fn of_decoded(name: &Path, file: &File, size: (usize, usize)) -> Result<Option<Field>, FieldError> {
        let store = decoded_doubles(file, size)
            .and_then(|store| Ok(store.zip(Some(file.metadata()?.len()))))
            .map_err(|source| FieldError::Map { path: name.to_path_buf(), source })?;
        Ok(store.map(|(store, bytes)| {
            let access = Access::Decoded { reason: "decoded before".to_string(), bytes };
            Field::of_store(name.to_path_buf(), size, SampleType::F64, store, access)
        }))
    }
}
