// The command line that gives the same answer.

const one = (values) => values.every((value) => value === values[0]);

/** The options of `telespring decide` for these values; null where only a file says it all. */
export function decideOptions(values) {
  const axes = ["x", "y", "z"].slice(0, values.axes.length);
  const isPlain =
    values.axes.length <= 3 &&
    values.axes.every((name, i) => name === axes[i]) &&
    values.session === "spring" &&
    values.jitter[0] === values.jitter[1] &&
    values.ages_from.length === 0 &&
    values.not_judged.length === 0 &&
    !values.has_uncertainty &&
    !values.names_arms_or_agents &&
    values.robots.every((robot) => robot.ground_stiffness.every((spring) => spring === 0)) &&
    values.operators.every((hand) => [hand.mass, hand.damping, hand.stiffness].every((ends) => ends.every((pair) => one(ends.map((p) => p[0])) && one(ends.map((p) => p[1])) && pair)));
  if (!isPlain) return null;
  const options = values.robots.map((robot) => `--robot ${robot.mass.map((mass, i) => `${mass},${robot.damping[i]}`).join("/")}`);
  values.operators.forEach((hand, i) => {
    const range = ([low, high]) => `${low}:${high}`;
    const parts = [hand.stiffness[0], hand.damping[0], hand.mass[0]];
    if (parts.flat().every((value) => value === 0)) return;
    while (parts.length > 1 && parts.at(-1).every((value) => value === 0)) parts.pop();
    options.push(`--grip${i + 1} ${parts.map(range).join(",")}`);
  });
  options.push(`--stiffness ${values.stiffness}`, `--delay ${values.delay[0]}`);
  if (values.delay[1] !== values.delay[0]) options.push(`--backward ${values.delay[1]}`);
  if (values.jitter[0] > 0) options.push(`--jitter ${values.jitter[0]}`);
  if (values.max_gap > 0) options.push(`--max-gap ${values.max_gap}`);
  if (values.playout_buffer) options.push("--playout-buffer");
  options.push(values.sample_period > 0 ? `--sample-period ${values.sample_period}` : "--continuous");
  if (values.computing_time > 0) options.push(`--computing-time ${values.computing_time}`);
  if (values.coupling_damping > 0) options.push(`--coupling-damping ${values.coupling_damping}`);
  if (values.allow_unusual) options.push("--allow-unusual");
  return options;
}

/** The command for these values; where options do not say it all, one for the saved study. */
export function decideCommand(values) {
  const options = decideOptions(values);
  return options ? `telespring decide ${options.join(" ")}` : "telespring decide study.toml";
}
