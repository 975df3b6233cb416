// The planner's reasons in plain words: "contact bounds of left_foot on stair_top: 1.7e-3 m off" says which row of the
// problem does not hold; a reader wants to know what that means for the robot.

/** Beyond the edge of a contact by more than this [m] is out of reach, rather than a matter of room. */
const BESIDE = 0.1;

const MEANINGS: [RegExp, (subject: string, amount: string, value: number) => string][] = [
  [/^contact distance/, (subject, amount) => `out of reach: ${subject} stay ${amount} apart`],
  [/^contact alignment/, (subject, amount) => `cannot lie flat: ${subject}, ${amount} tilted`],
  [/^contact bounds/, (subject, amount, value) => (value > BESIDE ? `out of reach: ${subject} stay ${amount} apart` : `no room: ${subject}, ${amount} over the edge`)],
  [/^contact (slip|velocity|spin)/, (subject, amount) => `cannot hold still: ${subject} would slip ${amount}`],
  [/^(clearance|collision|self.clearance)/, (subject, amount) => `collision: ${subject}, ${amount} too close`],
  [/^joint (range|position)/, (subject, amount) => `joint beyond its range: ${subject} by ${amount}`],
  [/^joint velocity/, (subject, amount) => `joint too fast: ${subject} by ${amount}`],
  [/^torque/, (subject, amount) => `torque beyond the limit: ${subject} by ${amount}`],
  [/^friction/, (subject, amount) => `would slide, not enough friction: ${subject} by ${amount}`],
  [/^(centre of pressure|cop)/, (subject, amount) => `would tip over the edge of the contact: ${subject} by ${amount}`],
  [/^(torsion)/, (subject, amount) => `would twist, not enough friction: ${subject} by ${amount}`],
  [/^(normal force|contact force)/, (subject, amount) => `force of a contact out of bounds: ${subject} by ${amount}`],
  [/^equations of motion/, (subject, amount) => `forces cannot carry the motion: ${amount} missing at ${subject}`],
  [/^goal/, (subject, amount) => `the goal is missed: ${subject} by ${amount}`],
];

/** An amount with a unit that suits its size. */
export function amount(value: number, unit: string): string {
  const round = (x: number) => String(Number(x.toPrecision(2)));
  if (unit === "m") return value >= 1 ? `${round(value)} m` : value >= 0.01 ? `${round(100 * value)} cm` : `${round(1000 * value)} mm`;
  if (unit === "rad") return `${round((value * 180) / Math.PI)}°`;
  return `${round(value)} ${unit}`.trim();
}

/** What a reason means; as it is where its form is not known. */
export function plain(reason: string): string {
  const grid = /^on a grid of (\S+ ms): (.*)$/s.exec(reason);
  if (grid) return `${plain(grid[2])} (in steps of ${grid[1]})`;
  const parts = /^(equations of motion|.+?) of (.+?): ([\d.]+(?:e[+-]?\d+)?) ?((?!off)\S+(?: m)?)? ?off,?\s*(.*)$/.exec(reason);
  if (!parts) return reason.replaceAll("_", " ");
  const [, row, subject, value, unit = "", rest] = parts;
  const meaning = MEANINGS.find(([pattern]) => pattern.test(row));
  const size = amount(Number(value), unit);
  const text = meaning ? meaning[1](subject, size, Number(value)) : `${row} of ${subject}: ${size} off`;
  return `${text}${rest ? `, ${rest}` : ""}`.replaceAll("_", " ");
}
