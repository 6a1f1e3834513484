// By what heights can be multiplied.

// Round factors around the usual one, and 1, which shows true proportions. The usual one makes the relief an eighth of the
// extent, but does not flatten what is steeper, up to a third.
export function factors(extent, relief) {
  const steep = relief / extent;
  const wanted = steep > 0 ? (steep < 0.125 ? 0.125 / steep : Math.min(1, 0.33 / steep)) : 1;
  const round = [];
  for (let power = -6; power <= 6; power++) for (const digit of [1, 1.5, 2, 3, 5, 7]) round.push(Number(`${digit}e${power}`));
  const usual = round.reduce((best, next) => (next <= wanted ? next : best));
  const list = round.filter(factor => factor === 1 || (factor >= usual / 10 && factor <= usual * 10));
  return { list, usual };
}
