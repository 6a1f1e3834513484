//! What fields of a layer say of its lines and polygons.

use gdal::vector::{Feature, FieldValue};

use super::shapes::Wrong;
use crate::base::LineType;

/// What holds for the features of a layer: the same for all, or for each what a text field says of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Said<T> {
    /// The same for all.
    Of(T),
    /// What each feature says in the field of this name.
    Field(String),
}

impl<T> Said<T> {
    pub(super) fn is_of_each(&self) -> bool {
        matches!(self, Said::Field(_))
    }
}

/// Whether the heights of a feature count.
pub(super) fn has_own_heights(said: &Said<bool>, (id, feature): (u64, &Feature<'_>)) -> Result<bool, Wrong> {
    let words = |text: &str| match text {
        "raster" => Some(false),
        "line" => Some(true),
        _ => None,
    };
    of_feature(said, "raster or line", words, (id, feature))
}

/// The type of a feature.
pub(super) fn type_of(said: &Said<LineType>, (id, feature): (u64, &Feature<'_>)) -> Result<LineType, Wrong> {
    of_feature(said, "hard or soft", LineType::from_name, (id, feature))
}

fn of_feature<T: Copy>(
    said: &Said<T>,
    expected: &str,
    words: impl Fn(&str) -> Option<T>,
    (id, feature): (u64, &Feature<'_>),
) -> Result<T, Wrong> {
    let field = match said {
        Said::Of(what) => return Ok(*what),
        Said::Field(name) => name,
    };
    let found = match value(feature, field) {
        Ok(Some(FieldValue::StringValue(text))) => match words(&text) {
            Some(what) => return Ok(what),
            None => format!("the text {text:?}"),
        },
        Ok(None) => "nothing".to_string(),
        Ok(Some(_)) => "no text, but another type".to_string(),
        Err(found) => found,
    };
    Err(Wrong::new(format!("the text {expected} in field {field} of feature {id}"), found))
}

/// The number that a feature has in a field.
pub(super) fn number(field: &str, (id, feature): (u64, &Feature<'_>)) -> Result<f64, Wrong> {
    let found = match value(feature, field) {
        Ok(Some(FieldValue::IntegerValue(whole))) => return Ok(f64::from(whole)),
        Ok(Some(FieldValue::Integer64Value(whole))) => return Ok(whole as f64),
        Ok(Some(FieldValue::RealValue(number))) if number.is_finite() => return Ok(number),
        Ok(Some(FieldValue::RealValue(number))) => number.to_string(),
        Ok(Some(FieldValue::StringValue(text))) => format!("the text {text:?}"),
        Ok(None) => "nothing".to_string(),
        Ok(Some(_)) => "another type".to_string(),
        Err(found) => found,
    };
    Err(Wrong::new(format!("a number in field {field} of feature {id}"), found))
}

/// What a feature has in a field, or what is wrong with it.
fn value(feature: &Feature<'_>, field: &str) -> Result<Option<FieldValue>, String> {
    let index = feature.field_index(field).map_err(|_| {
        let mut names: Vec<String> = feature.fields().map(|(name, _)| name).collect();
        names.sort_unstable();
        match names.is_empty() {
            true => "a layer without fields".to_string(),
            false => format!("no such field among {}", names.join(", ")),
        }
    })?;
    feature.field(index).map_err(|_| "what cannot be read".to_string())
}
