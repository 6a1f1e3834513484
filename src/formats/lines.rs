//! Headers made of lines, such as the comments of PLY and OBJ, as readers take them: `NAME VALUE`.

use super::{Header, OptionName, RunOption};
use crate::base::{CoordinateFrame, Window};

/// The header of which these are the lines, without the marks of comments. What is not as terrabite writes it is a note.
/// A line `precision float` says that coordinates are numbers of single precision; a format may know better.
pub(super) fn header<'a>(lines: impl IntoIterator<Item = &'a str>) -> Header {
    let mut header = Header::default();
    let mut frame = Found::default();
    for line in lines {
        if !take(&mut header, &mut frame, line) {
            header.notes.push(line.to_string());
        }
    }
    let plain = CoordinateFrame::PLAIN;
    header.frame = CoordinateFrame {
        origin: frame.origin.flatten().unwrap_or(plain.origin),
        xy_scale: frame.xy_scale.flatten().unwrap_or(plain.xy_scale),
        z_scale: frame.z_scale.flatten().unwrap_or(plain.z_scale),
        single: frame.single,
    };
    header
}

/// The first line of each kind counts; the inner `None` is one that means nothing.
#[derive(Default)]
struct Found {
    origin: Option<Option<(f64, f64)>>,
    xy_scale: Option<Option<(f64, f64)>>,
    single: bool,
    z_scale: Option<Option<f64>>,
}

/// Whether the line has a meaning.
fn take(header: &mut Header, frame: &mut Found, line: &str) -> bool {
    let value = |name: &str| line.strip_prefix(name)?.strip_prefix(' ');
    let text = |slot: &mut Option<String>, value: Option<&str>| {
        let is_new = slot.is_none();
        match value {
            Some(value) if is_new => *slot = Some(value.to_string()),
            _ => return false,
        }
        true
    };
    let definition = line.strip_prefix("crs:").or_else(|| value("map crs"));
    if text(&mut header.made_by, value("made by"))
        || text(&mut header.source, value("source"))
        || text(&mut header.crs.definition, definition)
        || text(&mut header.crs.name, value("crs name"))
        || text(&mut header.heights.crs, value("vertical crs"))
        || text(&mut header.heights.unit, value("height unit"))
    {
        return true;
    }
    if let Some(words) = value("offset")
        && frame.origin.is_none()
    {
        let origin = numbers::<2>(words).map(|[x, y]| (x, y));
        frame.origin = Some(origin);
        return origin.is_some();
    }
    if let Some(words) = value("xy_scale")
        && frame.xy_scale.is_none()
    {
        let factors = numbers::<2>(words).map(|[x, y]| (x, y)).filter(|(x, y)| *x > 0.0 && *y > 0.0);
        frame.xy_scale = Some(factors);
        return factors.is_some();
    }
    if line == "precision float" && !frame.single {
        frame.single = true;
        return true;
    }
    if let Some(words) = value("z_scale")
        && frame.z_scale.is_none()
    {
        let factor = numbers::<1>(words).map(|[f]| f).filter(|f| *f > 0.0);
        frame.z_scale = Some(factor);
        return factor.is_some();
    }
    if let Some(window) = value("window").and_then(window).filter(|_| header.window.is_none()) {
        header.window = Some(window);
        return true;
    }
    if let Some([tolerance]) = value("max_error").and_then(numbers).filter(|_| header.tolerance.is_none()) {
        header.tolerance = Some(tolerance);
        return true;
    }
    let option = OptionName::ALL.into_iter().find_map(|name| Some(RunOption::new(name, value(name.words())?)));
    let is_option = option.is_some();
    header.options.extend(option);
    is_option
}

/// So many finite numbers and no more.
fn numbers<const N: usize>(words: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = words.split_whitespace().map(|w| w.parse().ok()).collect();
    numbers.filter(|n| n.iter().all(|n| n.is_finite()))?.try_into().ok()
}

fn window(words: &str) -> Option<Window> {
    let numbers: Option<Vec<usize>> = words.split(',').map(|w| w.parse().ok()).collect();
    let [column, row, width, height] = numbers?.try_into().ok()?;
    Some(Window { column, row, width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(lines: &[&str]) -> CoordinateFrame {
        header(lines.iter().copied()).frame
    }

    #[test]
    fn other_lines_mean_nothing_for_coordinates() {
        for line in [
            "offset in feet",
            "offset 1",
            "offset 1 2 3",
            "offset 1 nan",
            "offsets 1 2",
            "z_scale 0",
            "z_scale -1",
            "xy_scale 1",
            "xy_scale 1 0",
        ] {
            assert_eq!(frame(&[line]), CoordinateFrame::PLAIN, "{line}");
            assert_eq!(header([line]).notes, [line]);
        }
        // The first counts.
        assert_eq!(frame(&["offset 1 2", "offset 3 4"]).origin, (1.0, 2.0));
        assert_eq!(frame(&["offset 1", "offset 3 4"]), CoordinateFrame::PLAIN);
    }

    #[test]
    fn lines_become_facts() {
        let lines =
            ["map crs EPSG:32633", "crs name x y", "window 1,2,3,4", "max_error 0.5", "cutline layer a b", "by hand"];
        let found = header(lines);
        assert_eq!((found.crs.definition.as_deref(), found.crs.name.as_deref()), (Some("EPSG:32633"), Some("x y")));
        assert_eq!(found.window, Some(Window { column: 1, row: 2, width: 3, height: 4 }));
        assert_eq!(found.tolerance, Some(0.5));
        assert_eq!(found.options, [RunOption::new(OptionName::CutlineLayer, "a b")]);
        assert_eq!(found.notes, ["by hand"]);
    }
}
