//! The pieces that pages are put together from. All text that comes in is made harmless here.

use std::fmt::Write;

use sha2::{Digest, Sha256};

use super::image::base64;

/// The bytes of a page that is mailed, at most.
const PAGE: usize = 3_000_000;

/// What a browser shows as this text, whatever is in it.
pub(super) fn text(text: &str) -> String {
    quick_xml::escape::escape(text).into_owned()
}

/// Names and values; values are HTML.
pub(super) fn facts(rows: &[(&str, String)]) -> String {
    let row =
        |(name, value): &(&str, String)| format!("<tr><th scope=\"row\">{}</th><td>{value}</td></tr>\n", text(name));
    format!("<table>\n{}</table>\n", rows.iter().map(row).collect::<String>())
}

/// A table with a line of titles; the cells are HTML. Columns from the second on hold numbers where `numbers` says so.
pub(super) fn table(titles: &[&str], numbers: &[bool], rows: &[Vec<String>]) -> String {
    let class = |column: usize| if numbers[column] { " class=\"n\"" } else { "" };
    let titles: String = titles
        .iter()
        .enumerate()
        .map(|(i, title)| format!("<th scope=\"col\"{}>{}</th>", class(i), text(title)))
        .collect();
    let row = |cells: &Vec<String>| {
        let cells: String = cells.iter().enumerate().map(|(i, cell)| format!("<td{}>{cell}</td>", class(i))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.iter().map(row).collect();
    format!("<div class=\"wide\"><table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n")
}

/// A chapter.
pub(super) fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{body}</section>\n", text(title))
}

/// A long chapter, which `body` adds to the page by itself.
pub(super) fn long_section<R>(page: &mut String, title: &str, body: impl FnOnce(&mut String) -> R) -> R {
    let _ = writeln!(page, "<section>\n<h2>{}</h2>", text(title));
    let result = body(page);
    page.push_str("</section>\n");
    result
}

/// A picture and what is to be seen; the caption is HTML.
pub(super) fn figure(title: &str, picture: &str, caption: &str) -> String {
    format!("<figure>\n<h3>{}</h3>\n{picture}<figcaption>{caption}</figcaption>\n</figure>\n", text(title))
}

/// Points of a list; they are HTML.
pub(super) fn list(points: &[String]) -> String {
    format!("<ul>\n{}</ul>\n", points.iter().map(|point| format!("<li>{point}</li>\n")).collect::<String>())
}

/// JSON that a program can take out of the page again, as the text of the element with this id.
pub(super) fn embedded_json(id: &str, json: &str) -> String {
    // No "</script>" and no "<!--" can be in it then; in JSON the escape is the same character.
    let json = json.replace('<', "\\u003c");
    format!("<script type=\"application/json\" id=\"{id}\">{json}</script>\n")
}

/// The beginning of a page, to which its chapters are added. The only program that it may run is `script`, where there is one.
pub(super) fn begin(title: &str, script: Option<&str>) -> String {
    let (title, style) = (text(title), include_str!("style.css"));
    let policy = script.map_or(String::new(), |script| {
        let sum = Sha256::digest(script.as_bytes());
        format!("; script-src 'sha256-{}'", base64(&sum))
    });
    // Of this memory no more is taken than is filled: a page is put together in one place.
    let mut page = String::with_capacity(PAGE);
    let _ = write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'{policy}\">\n\
         <link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
    );
    page
}

/// Ends a page that may run this program.
pub(super) fn end(page: &mut String, script: Option<&str>) {
    if let Some(script) = script {
        let _ = writeln!(page, "<script type=\"module\">{script}</script>");
    }
    page.push_str("</body>\n</html>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_cannot_become_markup() {
        assert_eq!(text("<img src=x onerror='a'>&\""), "&lt;img src=x onerror=&apos;a&apos;&gt;&amp;&quot;");
        let json = embedded_json("report", r#"{"file":"</script><!-- a"}"#);
        assert_eq!(json.matches('<').count(), 2);
        assert!(json.contains(r"\u003c/script>"));
    }
}
