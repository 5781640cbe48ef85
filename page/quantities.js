// The values that a study has controls for: what each is called, how far its slider goes, and how it is written.

const list = (values) => `[${values.join(", ")}]`;
const withAt = (values, at, value) => values.map((own, i) => (i === at ? value : own));
const areOne = (values) => values.every((value) => JSON.stringify(value) === JSON.stringify(values[0]));

/** Whether both ways of the network have the same delay and jitter. */
export const areWaysAlike = (values) => areOne(values.delay) && areOne(values.jitter);

/** Whether a hand holds every axis alike. */
export const areGripsAlike = (values) => values.operators.every((hand) => [hand.mass, hand.damping, hand.stiffness].every(areOne));

/** What makes both ways, or all axes of both hands, alike again: a table of changes. */
export const waysAlike = (values) => `network.delay = ${values.delay[0]}\nnetwork.jitter = ${values.jitter[0]}`;
export const gripsAlike = (values) =>
  values.operators.flatMap((hand, i) => ["mass", "damping", "stiffness"].map((key) => `operator${i + 1}.${key} = ${span(hand[key][0])}`)).join("\n");

const span = ([low, high]) => (low === high ? String(low) : `{min = ${low}, max = ${high}}`);

/** A time in ms, on a slider by decades. */
const milliseconds = (definition) => ({ unit: "ms", factor: 1e3, from: 0, to: 1, isLog: 1e-3, ...definition });

/** Delay or jitter: one control, or one for each way. */
function ofBothWays(key, isSplit, { name, names, to, hint }) {
  if (!isSplit) return [milliseconds({ id: key, label: name, to, of: (v) => v[key][0], toml: (_, value) => `network.${key} = ${value}`, hint })];
  return names.map((label, way) =>
    milliseconds({
      id: `${key}-${way + 1}`,
      label,
      to,
      of: (v) => v[key][way],
      toml: (v, value) => {
        const [forward, backward] = withAt(v[key], way, value);
        return `network.${key} = {forward = ${forward}, backward = ${backward}}`;
      },
    }),
  );
}

const springAndNetwork = (values, { hasOwnWays }) => [
  { id: "stiffness", label: "Stiffness of the spring", unit: "N/m", from: 1, to: 2000, isLog: 1, of: (v) => v.stiffness, toml: (_, k) => `coupling.stiffness = ${k}`, hint: "How hard the virtual spring pulls the two robots together." },
  ...ofBothWays("delay", hasOwnWays, { name: "Delay each way", names: ["Delay, robot 1 to 2", "Delay, robot 2 to 1"], to: 1, hint: "From the measurement of a position to its use at the partner; about half a ping." }),
  ...ofBothWays("jitter", hasOwnWays, { name: "Jitter", names: ["Jitter, robot 1 to 2", "Jitter, robot 2 to 1"], to: 0.3, hint: "By how much longer a packet may take than the delay." }),
  milliseconds({
    id: "sample-period",
    label: "Sample period of the controllers",
    to: values.usual.sample_period[1],
    isLog: 1e-4,
    of: (v) => v.sample_period,
    // a controller computes within its period
    toml: (v, h) => `controller.sample_period = ${h}${v.computing_time > 0 ? `\ncontroller.computing_time = ${Math.min(v.computing_time, h)}` : ""}`,
    hint: "0 is a continuous controller; a 1 kHz controller has 1 ms.",
  }),
];

const rarerValues = () => [
  milliseconds({ id: "max-gap", label: "Longest gap in the network", of: (v) => v.max_gap, toml: (_, gap) => `network.max_gap = ${gap}`, hint: "The longest time in which no newer sample arrives, such as while packets get lost." }),
  { id: "computing-time", label: "Computing time of a controller", unit: "ms", factor: 1e3, from: 0, to: (v) => v.sample_period, of: (v) => v.computing_time, toml: (_, time) => `controller.computing_time = ${time}`, hint: "From reading the samples to applying the force: at most the sample period, none for continuous controllers." },
  { id: "coupling-damping", label: "Damping of the coupling", unit: "N·s/m", from: 0, to: 200, isLog: 0.1, of: (v) => v.coupling_damping, toml: (_, damping) => `coupling.damping = ${damping}`, hint: "A virtual damper beside the spring, over the same network." },
];

/** A value of a robot, for each axis. */
function perAxis(values, i, key, definition) {
  return values.axes.map((axis, at) => ({
    ...definition,
    id: `${key.replace("_", "-")}-${i + 1}-${at}`,
    label: values.axes.length > 1 ? `${definition.label}, axis ${axis}` : definition.label,
    of: (v) => v.robots[i][key][at],
    toml: (v, value) => `robot${i + 1}.${key} = ${list(withAt(v.robots[i][key], at, value))}`,
  }));
}

const MASS = { label: "Mass", unit: "kg", from: 0.05, to: 50, isLog: 1 };
const DAMPING = { label: "Damping", unit: "N·s/m", from: 0, to: 200, isLog: 0.1 };

const robot = (values, i) => {
  const [masses, dampings] = [perAxis(values, i, "mass", MASS), perAxis(values, i, "damping", DAMPING)];
  return masses.flatMap((mass, at) => [mass, dampings[at]]);
};

const robotSprings = (values) =>
  [0, 1].flatMap((i) => perAxis(values, i, "ground_stiffness", { label: `Spring of robot ${i + 1} to the ground`, unit: "N/m", from: 0, to: 2000, isLog: 1 }));

const GRIPS = [
  ["stiffness", "Grip stiffness", "N/m", 2000, 1],
  ["damping", "Grip damping", "N·s/m", 50, 0.1],
  ["mass", "Mass of the hand", "kg", 5, 0.01],
];

/** How a hand holds a handle: the least and the most of each value, for all axes together or for each. */
function grip(values, i, { hasOwnGrips }) {
  const places = hasOwnGrips ? values.axes.map((axis, at) => [at, `, axis ${axis}`, `-${at}`]) : [[0, "", ""]];
  const ends = ["least", "most"];
  return GRIPS.flatMap(([key, name, unit, to, isLog]) =>
    places.flatMap(([at, on, mark]) =>
      ends.map((word, end) => ({
        id: `grip-${key}-${i + 1}-${end}${mark}`,
        label: `${name}, ${word}${on}`,
        unit,
        from: 0,
        to,
        isLog,
        of: (v) => v.operators[i][key][at][end],
        toml: (v, value) => {
          const [low, high] = v.operators[i][key][at];
          const own = end === 0 ? [value, Math.max(value, high)] : [Math.min(value, low), value];
          const all = hasOwnGrips ? list(withAt(v.operators[i][key], at, own).map(span)) : span(own);
          return `operator${i + 1}.${key} = ${all}`;
        },
      })),
    ),
  );
}

/** The groups of controls for a study, each {key, title, controls}; a group may be open at first, and have a note. */
export function groups(values, choices) {
  const name = (i) => (values.robots[i].name ? `Robot ${i + 1}: ${values.robots[i].name}` : `Robot ${i + 1}`);
  return [
    { key: "network", title: "Spring and network", controls: springAndNetwork(values, choices), isOpen: true },
    { key: "rarer", title: "More of network, controllers and coupling", controls: rarerValues() },
    { key: "robot1", title: name(0), controls: robot(values, 0), isOpen: true },
    { key: "robot2", title: name(1), controls: robot(values, 1), isOpen: true },
    { key: "springs", title: "Springs of the robots to the ground", controls: robotSprings(values), note: "A spring of a robot itself stays when a hand lets go. 0 is none." },
    { key: "hand1", title: "Hand at robot 1", controls: grip(values, 0, choices), note: "All 0 is a free handle. From least to most: the answer holds for every hand between them, and for a free handle." },
    { key: "hand2", title: "Hand at robot 2", controls: grip(values, 1, choices) },
  ];
}
