//! Comments that are too long for a line.

/// The most bytes of a comment in one line: with the keyword and the mark of one that goes on, the line has 500.
const MOST: usize = 490;

/// The fewest where the comment goes on in the next line: readers that join lines join none that is shorter.
const FEWEST: usize = 480;

/// A comment in pieces of one line each. None of them begins or ends with a blank but where the comment does: readers cut them
/// off. In the midst of more than ten blanks there is no good place, so there a line is longer.
pub(super) fn pieces(comment: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(comment);
    std::iter::from_fn(move || {
        let text = rest.take()?;
        let (piece, further) = cut(text).map_or((text, None), |at| (&text[..at], Some(&text[at..])));
        rest = further;
        Some(piece)
    })
}

/// Where to go on in the next line; `None` for what fits into one.
fn cut(text: &str) -> Option<usize> {
    let is_good = |at: &usize| {
        let (before, after) = (text[..*at].chars().next_back(), text[*at..].chars().next());
        [before, after].into_iter().all(|c| c.is_some_and(|c| !c.is_whitespace()))
    };
    let places = |range: std::ops::Range<usize>| range.filter(|at| text.is_char_boundary(*at));
    if text.len() <= MOST {
        return None;
    }
    places(FEWEST..MOST + 1).rev().find(is_good).or_else(|| places(MOST + 1..text.len()).find(is_good))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn lines_are_cut_between_letters() {
        let (short, long) = ("x".repeat(490), "ä".repeat(700));
        assert_eq!(pieces(&short).collect::<Vec<_>>(), [short.as_str()]);
        assert_eq!(pieces(&long).map(str::len).collect::<Vec<_>>(), [490, 490, 420]);
        let blanks = format!("{}{}x", "x".repeat(470), " ".repeat(50));
        assert_eq!(pieces(&blanks).map(str::len).collect::<Vec<_>>(), [521]);
        assert_eq!(pieces(&format!("{blanks}yz")).map(str::len).collect::<Vec<_>>(), [521, 2]);
        assert_eq!(pieces("").collect::<Vec<_>>(), [""]);
    }

    proptest! {
        #[test]
        fn pieces_are_the_whole(text in "[ -~äß⛰]{0,1500}") {
            let all: Vec<&str> = pieces(&text).collect();
            prop_assert_eq!(all.concat(), text.as_str());
            prop_assert!(all.iter().all(|piece| piece.len() <= MOST || piece.contains("        ")));
            for (i, piece) in all.iter().enumerate() {
                prop_assert!(i + 1 == all.len() || piece.len() >= FEWEST && !piece.ends_with(' '));
                prop_assert!(i == 0 || !piece.starts_with(' '));
            }
        }
    }
}
