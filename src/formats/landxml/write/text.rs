//! Texts in XML 1.0, which cannot hold all characters.

/// A text as a value of an attribute, between double quotes. Characters that XML 1.0 cannot hold become U+FFFD.
pub(super) fn attribute(text: &str) -> String {
    let mut value = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => value.push_str("&amp;"),
            '<' => value.push_str("&lt;"),
            '>' => value.push_str("&gt;"),
            '"' => value.push_str("&quot;"),
            // As they are they would be read as blanks.
            '\t' | '\n' | '\r' => value.push_str(&format!("&#{};", c as u32)),
            c if is_held(c) => value.push(c),
            _ => value.push(char::REPLACEMENT_CHARACTER),
        }
    }
    value
}

/// A text in characters that XML 1.0 can hold, which comes back: `\\` is a backslash, `\u0000` the character with this
/// number in hexadecimal digits.
pub(super) fn fact(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' => escaped.push_str("\\\\"),
            c if is_held(c) => escaped.push(c),
            // None of them has a larger number.
            c => escaped.push_str(&format!("\\u{:04x}", c as u32)),
        }
    }
    escaped
}

/// Whether XML 1.0 knows the character.
fn is_held(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..)
}

/// A text as a comment, in which two hyphens may not stand together.
pub(super) fn comment(text: &str) -> String {
    let mut comment = String::from("<!-- ");
    for c in text.chars() {
        if c == '-' && comment.ends_with('-') {
            comment.push(' ');
        }
        comment.push(if is_held(c) { c } else { char::REPLACEMENT_CHARACTER });
    }
    comment + " -->\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn awkward_characters() {
        assert_eq!(
            attribute("a<b> & \"c\" 'd'\t\u{0}\u{ffff}ß⛰"),
            "a&lt;b&gt; &amp; &quot;c&quot; 'd'&#9;\u{fffd}\u{fffd}ß⛰"
        );
        assert_eq!(fact("a\\\u{0}\u{1b}\u{fffe}\u{7f}😀"), "a\\\\\\u0000\\u001b\\ufffe\u{7f}😀");
        assert_eq!(comment("a---b-"), "<!-- a- - -b- -->\n");
    }
}
