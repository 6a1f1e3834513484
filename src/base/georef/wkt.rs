//! A CRS as well-known text: what is read of it where no library of CRSs is at hand (OGC 01-009, and the words of
//! ISO 19162 for the same).

use super::{Metres, Reference};

/// What a CRS says, as [`Reference`] and the header of a mesh have it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CrsFacts {
    /// Its authority and code, such as `EPSG:32633`; of a compound CRS without one that of its horizontal part; else the
    /// text itself; `None` where there is no CRS.
    pub definition: Option<String>,
    /// Authority, code and name in one line; "none" where there is no CRS.
    pub name: String,
    /// Whether x and y are longitude and latitude.
    pub geographic: bool,
    /// The unit of x and y; empty where it is not said.
    pub unit: String,
    /// How long it is.
    pub metres: Option<Metres>,
    /// The vertical CRS; empty where there is none.
    pub vertical_crs: String,
    /// The unit of its heights; empty where there is none.
    pub vertical_unit: String,
}

/// Brackets in brackets beyond which a text is none that anybody has written.
const DEPTH: usize = 32;

/// `NAME[value, …]`.
#[derive(Debug, Default)]
struct Node<'t> {
    keyword: &'t str,
    /// Texts, without quotes, and numbers.
    words: Vec<&'t str>,
    nodes: Vec<Node<'t>>,
}

impl CrsFacts {
    /// What a text says; a text that is no WKT is taken for the name and definition of a CRS of which nothing else is known.
    pub fn of_text(text: &str) -> CrsFacts {
        let text = text.trim();
        if text.is_empty() {
            return CrsFacts { name: "none".to_string(), ..CrsFacts::default() };
        }
        match (Parser { rest: text }).node(0) {
            Some(root) => CrsFacts::of_root(&root, text),
            None => CrsFacts { definition: Some(text.to_string()), name: text.to_string(), ..CrsFacts::default() },
        }
    }

    fn of_root(root: &Node<'_>, text: &str) -> CrsFacts {
        let horizontal = root.find(PROJECTED).or_else(|| root.find(GEOGRAPHIC)).unwrap_or(root);
        let geographic = horizontal.is(GEOGRAPHIC);
        let unit = horizontal.unit();
        let factor = unit.and_then(|unit| unit.number(1));
        let metres = match geographic {
            true => factor.and_then(|radians| horizontal.find(ELLIPSOID)?.on_ellipsoid(radians)),
            false => factor.filter(|metres| *metres > 0.0 && horizontal.is(PROJECTED)).map(Metres::PerUnit),
        };
        let name = root.words.first().copied().unwrap_or_default();
        let vertical = root.find(VERTICAL);
        let of_part = || if root.is(COMPOUND) { horizontal.code() } else { None };
        let words = |node: Option<&Node<'_>>| {
            node.and_then(|node| node.words.first()).map_or(String::new(), |word| word.to_string())
        };
        CrsFacts {
            definition: Some(root.code().or_else(of_part).unwrap_or_else(|| text.to_string())),
            name: match root.code() {
                Some(code) => format!("{code} ({name})"),
                None if name.is_empty() => "none".to_string(),
                None => name.to_string(),
            },
            geographic,
            unit: words(unit),
            metres,
            vertical_crs: words(vertical),
            vertical_unit: words(vertical.and_then(Node::unit)),
        }
    }
}

impl Reference {
    /// What a raster's coordinates and heights mean: by its CRS, the unit that its band names (empty where it names none),
    /// whether it has a geotransform, its largest x, and what its pixels are.
    pub fn of_crs(crs: &CrsFacts, band_unit: &str, georeferenced: bool, largest_x: f64, pixel_is: &str) -> Reference {
        let height_unit = if band_unit.is_empty() { &crs.vertical_unit } else { band_unit };
        Reference {
            crs: crs.name.clone(),
            georeferenced,
            geographic: crs.geographic,
            longitudes_beyond_180: crs.geographic && largest_x > 180.0,
            unit: crs.unit.clone(),
            metres: crs.metres,
            vertical_crs: crs.vertical_crs.clone(),
            height_unit: height_unit.to_string(),
            pixel_is: pixel_is.to_string(),
        }
    }
}

const COMPOUND: &[&str] = &["COMPD_CS", "COMPOUNDCRS"];
const PROJECTED: &[&str] = &["PROJCS", "PROJCRS"];
const GEOGRAPHIC: &[&str] = &["GEOGCS", "GEOGCRS", "GEODCRS"];
const VERTICAL: &[&str] = &["VERT_CS", "VERTCRS"];
const ELLIPSOID: &[&str] = &["SPHEROID", "ELLIPSOID"];
const UNIT: &[&str] = &["UNIT", "LENGTHUNIT", "ANGLEUNIT"];
const AUTHORITY: &[&str] = &["AUTHORITY", "ID"];

impl<'t> Node<'t> {
    fn is(&self, keywords: &[&str]) -> bool {
        keywords.iter().any(|keyword| keyword.eq_ignore_ascii_case(self.keyword))
    }

    /// It, or the first node in it, that is called so.
    fn find(&self, keywords: &[&str]) -> Option<&Node<'t>> {
        if self.is(keywords) { Some(self) } else { self.nodes.iter().find_map(|node| node.find(keywords)) }
    }

    fn child(&self, keywords: &[&str]) -> Option<&Node<'t>> {
        self.nodes.iter().find(|node| node.is(keywords))
    }

    /// Its own unit, or that of its axes (ISO 19162 has it there, or once behind them).
    fn unit(&self) -> Option<&Node<'t>> {
        let of_axis = || self.nodes.iter().filter(|node| node.is(&["AXIS"])).find_map(|axis| axis.child(UNIT));
        self.child(UNIT).or_else(of_axis)
    }

    fn number(&self, index: usize) -> Option<f64> {
        self.words.get(index)?.parse().ok()
    }

    /// Authority and code, which is a number.
    fn code(&self) -> Option<String> {
        let words = &self.child(AUTHORITY)?.words;
        let (authority, code) = (words.first()?, words.get(1)?.parse::<i32>().ok()?);
        Some(format!("{authority}:{code}"))
    }

    fn on_ellipsoid(&self, radians: f64) -> Option<Metres> {
        let (semi_major, inverse_flattening) = (self.number(1)?, self.number(2)?);
        let flattening = if inverse_flattening == 0.0 { 0.0 } else { 1.0 / inverse_flattening };
        let semi_minor = semi_major * (1.0 - flattening);
        (semi_minor > 0.0).then_some(Metres::OnEllipsoid { semi_major, semi_minor, radians })
    }
}

/// Reads on in a text.
struct Parser<'t> {
    rest: &'t str,
}

impl<'t> Parser<'t> {
    fn skip(&mut self, found: char) -> bool {
        self.rest = self.rest.trim_start();
        let after = self.rest.strip_prefix(found);
        self.rest = after.unwrap_or(self.rest);
        after.is_some()
    }

    /// A text in quotes; quotes in it are doubled, and stay so.
    fn quoted(&mut self) -> Option<&'t str> {
        let mut ends = self.rest.match_indices('"').map(|(at, _)| at);
        let end = loop {
            let end = ends.next()?;
            if !self.rest[end + 1..].starts_with('"') {
                break end;
            }
            ends.next();
        };
        let text = &self.rest[..end];
        self.rest = &self.rest[end + 1..];
        Some(text)
    }

    fn word(&mut self) -> &'t str {
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c: char| ",[]()\"".contains(c) || c.is_whitespace()).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }

    fn node(&mut self, depth: usize) -> Option<Node<'t>> {
        let keyword = self.word();
        if depth > DEPTH || keyword.is_empty() || !(self.skip('[') || self.skip('(')) {
            return None;
        }
        let mut node = Node { keyword, ..Node::default() };
        loop {
            if self.skip('"') {
                node.words.push(self.quoted()?);
            } else {
                let before = self.rest;
                let word = self.word();
                if self.rest.trim_start().starts_with(['[', '(']) {
                    self.rest = before;
                    node.nodes.push(self.node(depth + 1)?);
                } else {
                    node.words.push(word);
                }
            }
            if self.skip(']') || self.skip(')') {
                return Some(node);
            }
            if !self.skip(',') {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WGS84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]]],
        PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]]"#;

    fn utm(authority: &str) -> String {
        format!(
            r#"PROJCS["WGS 84 / UTM zone 33N",{WGS84},PROJECTION["Transverse_Mercator"],PARAMETER["false_easting",500000],UNIT["metre",1]{authority}]"#
        )
    }

    #[test]
    fn projected_and_geographic() {
        let found = CrsFacts::of_text(&utm(r#",AUTHORITY["EPSG","32633"]"#));
        assert_eq!(found.definition.as_deref(), Some("EPSG:32633"));
        assert_eq!((found.name.as_str(), found.unit.as_str()), ("EPSG:32633 (WGS 84 / UTM zone 33N)", "metre"));
        assert_eq!((found.geographic, found.metres), (false, Some(Metres::PerUnit(1.0))));
        let found = CrsFacts::of_text(WGS84);
        assert_eq!((found.definition.as_deref(), found.unit.as_str()), (Some("EPSG:4326"), "degree"));
        assert!(found.geographic);
        assert_eq!(found.metres.map(|metres| metres.at(0.0)), Some((111_319.5, 110_574.3)));
    }

    #[test]
    fn compound_without_a_code_and_custom() {
        let vertical = r#"VERT_CS["EGM96 height",VERT_DATUM["EGM96 geoid",2005],UNIT["foot",0.3048]]"#;
        let compound = format!(r#"COMPD_CS["both",{},{vertical}]"#, utm(r#",AUTHORITY["EPSG","32633"]"#));
        let found = CrsFacts::of_text(&compound);
        assert_eq!((found.definition.as_deref(), found.name.as_str()), (Some("EPSG:32633"), "both"));
        assert_eq!((found.vertical_crs.as_str(), found.vertical_unit.as_str()), ("EGM96 height", "foot"));
        let custom = utm("");
        let found = CrsFacts::of_text(&custom);
        assert_eq!(found.definition, Some(custom), "of a part of it no code is taken");
        assert_eq!(found.name, "WGS 84 / UTM zone 33N");
    }

    #[test]
    fn other_words_for_the_same() {
        let text = r#"PROJCRS["a ""zone""",BASEGEOGCRS["b",DATUM["c",ELLIPSOID["d",6378137,298.25]]],CONVERSION["e"],
            CS[Cartesian,2],AXIS["(E)",east],AXIS["(N)",north],LENGTHUNIT["US survey foot",0.304800609601219],ID["EPSG",2263]]"#;
        let found = CrsFacts::of_text(text);
        assert_eq!((found.definition.as_deref(), found.unit.as_str()), (Some("EPSG:2263"), "US survey foot"));
        assert_eq!(found.metres, Some(Metres::PerUnit(0.304_800_609_601_219)));
    }

    #[test]
    fn none_and_no_text_of_this_kind() {
        assert_eq!((CrsFacts::of_text(" ").definition, CrsFacts::of_text("").name.as_str()), (None, "none"));
        let nested = "A[".repeat(1000);
        for text in ["EPSG:3857", "PROJCS[\"open", "PROJCS[\"a\"", "[", nested.as_str()] {
            assert_eq!(CrsFacts::of_text(text).definition.as_deref(), Some(text));
        }
    }
}
