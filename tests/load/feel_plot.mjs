// Scale and rate of a drag over its time, as an SVG.

const [WIDTH, HEIGHT, LEFT, TOP] = [720, 240, 48, 24];

const path = (points) => points.map(([x, y], i) => `${i === 0 ? 'M' : 'L'}${x.toFixed(1)} ${y.toFixed(1)}`).join('');

/** `pictures`: [seconds, scale] of each. */
export function dragPlot({ scene, line, pictures }) {
  const end = pictures.at(-1)?.[0] ?? 1;
  const x = (seconds) => LEFT + (seconds / end) * (WIDTH - LEFT - 48);
  const most = 60;
  const y = (share) => HEIGHT - 32 - share * (HEIGHT - 32 - TOP);
  const scales = [];
  for (const [time, scale] of pictures) {
    if (scales.length > 0) scales.push([x(time), scales.at(-1)[1]]);
    scales.push([x(time), y(scale)]);
  }
  // Over half a second each.
  const rates = pictures
    .filter(([time]) => time >= 0.5)
    .map(([time]) => [x(time), y(Math.min(1, pictures.filter(([t]) => t > time - 0.5 && t <= time).length / 0.5 / most))]);
  const grid = [0, 0.25, 0.5, 0.75, 1].map(
    (share) =>
      `<path d="M${LEFT} ${y(share)}H${WIDTH - 48}" stroke="#ddd"/>` +
      `<text x="${LEFT - 6}" y="${y(share) + 4}" text-anchor="end" fill="#1f5fbf">${share}</text>` +
      `<text x="${WIDTH - 42}" y="${y(share) + 4}" fill="#c2461f">${share * most}</text>`,
  );
  const seconds = Array.from({ length: Math.floor(end) + 1 }, (_, s) => `<text x="${x(s)}" y="${HEIGHT - 12}" text-anchor="middle">${s} s</text>`);
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="sans-serif" font-size="11">
<rect width="${WIDTH}" height="${HEIGHT}" fill="#fff"/>
<text x="${LEFT}" y="14">${scene}, ${line}: <tspan fill="#1f5fbf">scale</tspan> and <tspan fill="#c2461f">pictures a second</tspan></text>
${grid.join('\n')}
${seconds.join('\n')}
<path d="${path(scales)}" fill="none" stroke="#1f5fbf" stroke-width="2"/>
<path d="${path(rates)}" fill="none" stroke="#c2461f" stroke-width="1.5"/>
</svg>
`;
}
