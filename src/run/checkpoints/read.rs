//! Reading a table of checkpoints.

use std::path::{Path, PathBuf};

/// Why a table of checkpoints cannot be used. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The table.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Its first line does not name a column.
    #[error("{}: expected a first line that names the columns x, y and z (and id and cover, if there are any), found {found:?}", path.display())]
    Header {
        /// The table.
        path: PathBuf,
        /// The first line.
        found: String,
    },
    /// A line is no checkpoint.
    #[error("{}, line {line}: expected {expected}, found {found:?}", path.display())]
    Line {
        /// The table.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What should be there.
        expected: &'static str,
        /// What is.
        found: String,
    },
    /// There is no checkpoint in it.
    #[error("{}: expected at least one checkpoint after the first line, found none", path.display())]
    Empty {
        /// The table.
        path: PathBuf,
    },
    /// The coordinates cannot be brought into the CRS of the raster.
    #[error("{}: expected coordinates that can be brought from {from} into the CRS of the raster, found: {reason}", path.display())]
    Crs {
        /// The table.
        path: PathBuf,
        /// The CRS that was named.
        from: String,
        /// Why not.
        reason: String,
    },
}

/// What the ground is covered with, at a checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cover {
    /// Open ground: bare, short grass, urban.
    NonVegetated,
    /// Tall grass, brush, forest.
    Vegetated,
}

/// A place whose height was surveyed.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// What it is called; its line in the table where that has no column `id`.
    pub id: String,
    /// Its place on the map, and its height.
    pub place: [f64; 3],
    /// What is around it, if the table says so.
    pub cover: Option<Cover>,
}

/// Reads a table: a first line with the names of columns, then a checkpoint a line. Columns are separated by commas, semicolons, tabs
/// or, where the first line has none of these, by blanks; others than x, y, z, id and cover are passed over. Empty lines and those
/// that begin with # are, too.
pub(super) fn read(path: &Path) -> Result<Vec<Checkpoint>, CheckpointError> {
    let bytes = std::fs::read(path).map_err(|source| CheckpointError::Read { path: path.to_path_buf(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    parse(path, text.strip_prefix('\u{feff}').unwrap_or(&text))
}

fn parse(path: &Path, text: &str) -> Result<Vec<Checkpoint>, CheckpointError> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let header = lines.next().map_or("", |(_, line)| line);
    let separator = [';', '\t', ','].into_iter().find(|separator| header.contains(*separator));
    let names: Vec<String> = fields(header, separator).iter().map(|name| name.to_ascii_lowercase()).collect();
    let column = |name: &str| names.iter().position(|found| found == name);
    let (Some(x), Some(y), Some(z)) = (column("x"), column("y"), column("z")) else {
        return Err(CheckpointError::Header { path: path.to_path_buf(), found: shortened(header) });
    };
    let (id, cover) = (column("id"), column("cover"));
    let checkpoint = |(line, text): (usize, &str)| {
        let fields = fields(text, separator);
        let wrong = |expected, found: &str| CheckpointError::Line {
            path: path.to_path_buf(),
            line,
            expected,
            found: shortened(found),
        };
        let number = |column: usize, expected| {
            let field = fields.get(column).ok_or_else(|| wrong("as many columns as the first line has", text))?;
            field.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| wrong(expected, field))
        };
        let place = [number(x, "a number for x")?, number(y, "a number for y")?, number(z, "a number for z")?];
        let field = |column: Option<usize>| column.and_then(|column| fields.get(column)).filter(|f| !f.is_empty());
        let cover = match field(cover).map(|word| word.to_ascii_lowercase()) {
            None => None,
            Some(word) if word == "n" => Some(Cover::NonVegetated),
            Some(word) if word == "v" => Some(Cover::Vegetated),
            Some(word) => return Err(wrong("N (not vegetated), V (vegetated) or nothing for cover", &word)),
        };
        Ok(Checkpoint { id: field(id).map_or_else(|| format!("line {line}"), String::clone), place, cover })
    };
    let found: Vec<Checkpoint> = lines.map(checkpoint).collect::<Result<_, _>>()?;
    if found.is_empty() { Err(CheckpointError::Empty { path: path.to_path_buf() }) } else { Ok(found) }
}

/// The fields of a line without blanks and quotation marks around them. A separator between quotation marks is none.
fn fields(line: &str, separator: Option<char>) -> Vec<String> {
    let Some(separator) = separator else { return line.split_whitespace().map(str::to_string).collect() };
    let mut is_quoted = false;
    let parts = line.split(|c: char| {
        is_quoted ^= c == '"';
        c == separator && !is_quoted
    });
    parts.map(|part| part.trim().trim_matches('"').trim().to_string()).collect()
}

/// The beginning of a line, for a message.
fn shortened(text: &str) -> String {
    text.chars().take(80).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Vec<Checkpoint>, String> {
        parse(Path::new("gcp.csv"), text).map_err(|e| e.to_string())
    }

    #[test]
    fn columns_stand_in_any_order_and_with_any_separator() {
        let expected = Checkpoint { id: "A 1".into(), place: [1.5, -2.0, 3e2], cover: Some(Cover::Vegetated) };
        for text in [
            "x,y,z,id,cover\n1.5,-2,3e2,A 1,V\n",
            "\u{feff}ID;Cover;Z;Y;X;note\r\n\r\n# surveyed in May\r\n\"A 1\";v;300; -2.0 ;1.5;\"a;b\"\r\n",
            "cover\tid\tx\ty\tz\nv\tA 1\t1.5\t-2\t300",
        ] {
            assert_eq!(
                parse(Path::new("gcp.csv"), text.strip_prefix('\u{feff}').unwrap_or(text)).unwrap(),
                std::slice::from_ref(&expected),
                "{text}"
            );
        }
        let plain = parsed("x y z\n1 2 3\n\n4 5 6\n").unwrap();
        assert_eq!((plain[1].id.as_str(), plain[1].place, plain[1].cover), ("line 4", [4.0, 5.0, 6.0], None));
    }

    #[test]
    fn what_is_wrong_is_named_by_its_line() {
        for (text, words) in [
            ("", "names the columns x, y and z"),
            ("easting,northing,z\n1,2,3\n", "found \"easting,northing,z\""),
            ("x,y,z\n", "at least one checkpoint"),
            ("x,y,z\n1,2,3\n1,2\n", "line 3: expected as many columns"),
            ("x;y;z\n1;2;3,5\n", "line 2: expected a number for z, found \"3,5\""),
            ("x,y,z\nnan,2,3\n", "a number for x"),
            ("x,y,z,cover\n1,2,3,forest\n", "N (not vegetated), V (vegetated) or nothing"),
        ] {
            let error = parsed(text).unwrap_err();
            assert!(error.contains(words) && error.contains("gcp.csv"), "{error}");
        }
    }
}
