/// `WxH`, two whole numbers.
pub(super) fn parse_size(text: &str) -> Result<(usize, usize), String> {
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    sides.ok_or_else(|| format!("expected WIDTHxHEIGHT, for example 1024x768, found {text:?}"))
}
