"use strict";
// The tasks. Each is checked by what C++ has answered; `ask(values)` asks it for other settings of the same panel.
//   start    the settings at which it begins
//   keep     figures that may be seen before the prediction
//   options  predictions; a word names a text, a number is itself
//   right    which of them is right
//   control  the one setting that it needs; without, it is solved in its picture
//   picture  figures that are not folded
//   number   [now, goal], and what part of the way that is, if not the smaller of their ratios
//   solved   whether the picture's answer `a` at `values` does what is asked for

const decades = (from, to) => Array.from({length: to - from + 1}, (_, i) => `1e${from + i}`.replace(/^1e0$/, "1"));
const largest = numbers => numbers.indexOf(Math.max(...numbers));
const rejected = a => a.trials.filter(trial => trial.solved && !trial.accepted).length;
const each = (items, f) => Promise.all(items.map(f));

// So many of the last frame's observations stay, of six landmarks.
const keepObservations = count => ({without: Array.from({length: 6 - count}, (_, k) => `${k}:2`).join(",")});
const seenBy = (a, frame) => a.residuals.values.slice(frame * a.residuals.cols, (frame + 1) * a.residuals.cols)
  .filter(value => value !== null).length;

const CHALLENGES = [
  {
    id: "weight", panel: "solve", start: {start: "0.1", information: "noise", damping: "diagonal"}, keep: [],
    control: "weight", picture: ["cost"],
    options: ["0", "1e1", "1e5", "1e10"],
    right: async ask => largest(await each(["0", "1e1", "1e5", "1e10"], async weight => (await ask({weight})).iterations)),
    number: async (a, ask) => [a.iterations, Math.max(...await each(decades(-3, 10), async weight => (await ask({weight})).iterations))],
    solved: (a, values, ask, [now, goal]) => now >= goal,
  },
  {
    id: "gauge", panel: "solve", start: {}, keep: ["scene", "observations"], control: "gauge", picture: ["spectrum"], options: ["0", "3", "6", "7"],
    right: async ask => [0, 3, 6, 7].indexOf((await ask({gauge: "free"})).null_H),
    number: async (a, ask) => [a.null_H, (await ask({gauge: "free"})).null_H],
    solved: (a, values, ask, [now, goal]) => values.motion === "arc" && now === goal,
  },
  {
    id: "rotation", panel: "solve", start: {gauge: "fixed", frames: "2"}, keep: ["scene", "observations", "H"],
    control: "motion", picture: ["scene"],
    options: ["0", "1", "7", "20"],
    right: async ask => [0, 1, 7, 20].indexOf((await ask({motion: "turn"})).null_H),
    number: a => [a.null_H, a.truth.points.length],
    solved: (a, values, ask, [now, goal]) => now >= goal,
  },
  {
    id: "baseline", panel: "solve", start: {gauge: "fixed", frames: "2"}, keep: ["scene"], picture: ["scene"], options: ["nearer", "farther"],
    right: async ask => largest(await each(["1:1.9:-4.6", "1:-1.9:3.6"], async cameras => (await ask({cameras})).rmse_point)),
    number: async (a, ask) => [a.rmse_point, 4 * (await ask({})).rmse_point],
    solved: (a, values, ask, [now, goal]) => now >= goal && values.noise === "0.001",
  },
  {
    id: "fewest", panel: "solve", start: {gauge: "fixed", points: "6"}, keep: ["scene", "observations"],
    picture: ["observations", "scene"],
    options: ["1", "2", "3", "6"],
    right: async ask => (await each([1, 2, 3, 6], async count => (await ask(keepObservations(count))).null_H)).indexOf(0),
    number: async (a, ask) => [seenBy(a, 2), [1, 2, 3, 6][await CHALLENGES.find(one => one.id === "fewest").right(ask)]],
    solved: (a, values, ask, [now, goal]) => values.frames === "3" && a.null_H === 0 && now === goal,
  },
  {
    id: "liar", panel: "solve", start: {outliers: "1", information: "noise"}, keep: ["scene"], picture: ["observations", "scene"],
    options: ["yes", "no"],
    right: async ask => {
      const {values, cols, rows} = (await ask({})).residuals;
      return largest(values) === (rows - 1) * cols ? 0 : 1;  // the last frame's of landmark 0
    },
    number: async (a, ask) => [a.observation_cost, 0.2 * (await ask({})).observation_cost],
    solved: (a, values, ask, [now, goal]) => values.outliers === "1" && values.without.split(",").length === 1 && now < goal,
  },
  {
    id: "reject", panel: "steps", start: {start: "0.8", stop: "judge"}, keep: [], control: "tau", picture: ["trials"],
    options: ["1e-12", "1e-5", "1"],
    right: async ask => largest(await each(["1e-12", "1e-5", "1"], async tau => rejected(await ask({tau})))),
    number: a => [rejected(a), 1],
    solved: (a, values, ask, [now, goal]) => values.algorithm === "lm" && now >= goal,
  },
  {
    id: "fill", panel: "marginalize", start: {}, keep: ["H.before"], picture: ["drop", "H.after"],
    options: ["landmark.0", "pose.0", "pose.2"],
    right: async ask => largest(await each(["3", "0", "2"], async drop => (await ask({drop})).filled)),
    number: async (a, ask) => [a.dropped.length === 1 ? a.filled : 0,
      Math.max(...await each(a.before.variables, async (_, at) => (await ask({drop: String(at)})).filled))],
    solved: (a, values, ask, [now, goal]) => a.dropped.length === 1 && now === goal,
  },
  {
    id: "order", panel: "marginalize", start: {system: "chain"}, keep: ["H.before"], picture: ["drop", "H.after"], options: ["end", "middle"],
    right: async ask => (await each(["0", "1"], async drop => (await ask({drop})).filled)).indexOf(0),
    number: async (a, ask, {drop}) => [(await ask({drop: drop.split(",")[0]})).filled ? 0 : a.dropped.length, 2],
    solved: (a, values, ask, [now, goal]) => values.system === "chain" && now === goal,
  },
  {
    id: "yaw", panel: "window", start: {image: "29"}, keep: ["frames.of"], control: "rate", picture: ["numbers.of"],
    options: ["vins", "okvis"],
    right: async ask => {
      const {vins, okvis} = await ask({});
      return largest([vins.yaw_information, okvis.yaw_information]);
    },
    number: async (a, ask) => {
      const usual = await ask({}), ratio = one => one.vins.yaw_information / one.okvis.yaw_information;
      return [ratio(usual) > 1 ? 1 / ratio(a) : ratio(a), 1];
    },
    solved: (a, values, ask, [now, goal]) => a.image === 29 && now > goal,
  },
  {
    id: "beat", panel: "eliminate", start: {}, keep: ["game"], picture: ["score", "game", "L", "H.after"], options: ["yes", "no"],
    right: async ask => (({amd, least}) => amd === least ? 0 : 1)(await ask({})),
    number: a => [a.fill, a.amd - 1, a.gone.length / a.nodes.length],
    solved: (a, values, ask, [now, goal]) => !a.left.length && now <= goal,
  },
];
