"use strict";
// What each panel shows of an answer. `set` changes settings, as a slider does.

const name = one => one.kind === "extrinsic" ? one.kind : say(`${one.kind}.n`, {n: one.number});

// A matrix with a line below it that tells the entry under the pointer.
function told(title, M, variables, {rest, ...options} = {}) {
  const words = rest || say("matrix.size", {rows: M.rows, cols: M.cols});
  const box = figure(title, words);
  const tell = (row, column) => {
    const [a, b] = [row, column].map(at => variables[variableAt(variables, at)]);
    const pair = a && b ? `${name(a)} × ${name(b)}: ` : "";
    box.lastChild.textContent = `${pair}(${row}, ${column}) = ${short(M.values[row * M.cols + column])}`;
  };
  const canvas = matrix(M, {variables, tell, label: `${title}. ${words}`, ...options});
  canvas.addEventListener("pointerleave", () => { box.lastChild.textContent = words; });
  box.insertBefore(canvas, box.lastChild);
  return box;
}

function views(answer, layers) {
  return [
    {name: text("truth"), color: "--gray", ...answer.truth},
    ...layers.filter(one => one[1]).map(([key, value, color, hollow]) => ({name: text(key), color, hollow, ...value})),
  ];
}

const posesOf = variables => variables.filter(one => one.kind === "pose" && one.row >= 0);

function drawSolve(a) {
  const trace = a.trace;
  const spectra = [{name: "H", values: a.spectrum_H, color: "--blue", dots: true}];
  if (a.spectrum_S) spectra.push({name: "S", values: a.spectrum_S, color: "--red", dots: true});
  return [
    told(text("H"), a.H, a.variables.filter(one => one.row >= 0)),
    a.S.rows ? told(text("S"), a.S, posesOf(a.variables)) : null,
    figure(text("scene"), say("scene.words", {at: short(a.rmse_position), aligned: short(a.rmse_position_aligned)}),
      scene(views(a, [["start.states", a.start, "--red", true], ["estimate", a.estimate, "--blue", false]]), text("scene"))),
    figure(text("cost"), say("cost.words", {iterations: a.iterations, end: text("end." + a.termination),
      observations: short(a.observation_cost), priors: short(a.prior_cost)}),
      chart({series: [{name: text("cost"), values: trace.map(row => row.cost), color: "--blue"},
        {name: "λ", values: trace.map((row, i) => i ? row.lambda : null), color: "--red", dashed: true}],
        x: text("iteration"), y: "", label: text("cost")})),
    figure(text("spectrum"), say("spectrum.words", {H: a.null_H, S: a.null_S ?? 0}),
      chart({series: spectra, x: text("index"), y: "", label: text("spectrum")})),
  ];
}

const STOPS = ["linearize", "build", "damp", "eliminate", "solve", "step", "judge"];

function stopPictures(a, stop) {
  const row = a.trials[a.trial], variables = a.variables.filter(one => one.row >= 0);
  const H = () => told(text("H"), a.H, variables);
  const moved = layers => figure(text("scene"), "", scene(views(a, layers), text("scene")));
  const from = ["linearized_at", a.linearized_at, "--red", true];
  const vector = (title, values) => figure(text(title), text("rows.words"), bars(values, a.pose_rows, text(title)));
  switch (stop) {
    case "linearize": return [moved([from])];
    case "build": return [H(), vector("b", a.b)];
    case "damp": return [H(), figure(text("diagonal"), say("damp.words", {lambda: short(row.lambda)}), chart({
      series: [{name: "diag H", values: a.H.values.filter((_, i) => i % (a.H.rows + 1) === 0), color: "--blue", dots: true},
        {name: "λD", values: a.damping, color: "--red", dots: true}], x: text("index"), y: "", label: text("diagonal")}))];
    case "eliminate": return [H(), told(text("S.damped"), a.S, posesOf(a.variables))];
    case "solve": return row.solved ? [vector("delta_x", a.delta_x)] : [element("p", {class: "bad"}, text("unsolved"))];
    case "step": return [moved([from, ["moved_to", a.moved_to, "--blue", false]])];
    default: return [];
  }
}

function drawSteps(a, set) {
  if (!a.trials.length) return [element("p", {}, text("end." + a.termination))];
  const stop = state.values.stop, at = STOPS.indexOf(stop), row = a.trials[a.trial];
  const go = by => {
    const place = STOPS.length * a.trial + at + by;
    set({trial: String(Math.floor(place / STOPS.length)), stop: STOPS[place % STOPS.length]});
  };
  const button = (key, by, off) => element("button", {type: "button", id: key, disabled: off, click: () => go(by)}, text(key));
  const stops = STOPS.map(one => element("button", {type: "button", id: `stop-${one}`, "aria-pressed": String(one === stop),
    click: () => set({stop: one})}, text(`stop.${one}`)));
  const verdict = one => element("span", {class: one.accepted ? "good" : "bad"},
    text(one.accepted ? "accepted" : one.solved ? "rejected" : "unsolved.short"));
  const rows = a.trials.map(one => [one.iteration, short(one.lambda), one.cost, one.predicted,
    one.decrease, one.gain, verdict(one)]);
  const heads = ["iteration", "lambda", "cost.before", "predicted", "actual", "gain", "verdict"].map(text);
  return [
    Object.assign(element("div", {}, element("div", {class: "row"}, button("back", -1, a.trial === 0 && at === 0),
      button("forward", 1, a.trial === a.trials.length - 1 && at === STOPS.length - 1),
      element("strong", {}, say("trial.words", {trial: a.trial + 1, trials: a.trials.length, iteration: row.iteration}))),
    element("div", {class: "row", role: "group", "aria-label": text("stops")}, ...stops),
    element("p", {id: "formula"}, text(`formula.${stop}`))), {style: "grid-column: 1 / -1"}),
    ...stopPictures(a, stop),
    Object.assign(figure(text("trials"), say("end.words", {end: text("end." + a.termination)}),
      table(heads, stop === "judge" ? rows : rows.slice(0, a.trial), stop === "judge" ? a.trial : -1)), {className: "wide"}),
  ];
}

function drawMarginalize(a, set) {
  const drops = state.values.drop ? state.values.drop.split(",") : [];
  const drop = position => { if (position >= 0 && a.after.variables.length > 1) set({drop: [...drops, position].join(",")}); };
  const chips = a.after.variables.map((one, i) => element("button", {type: "button", id: `drop-${i}`, click: () => drop(i)}, name(one)));
  const gone = a.dropped.map(name).join(text("comma")) || text("nothing");
  const numbers = values => values.length <= 6 ? `(${values.map(short).join(", ")})` : "";
  return [
    Object.assign(element("div", {},
      element("div", {class: "row"}, element("button", {type: "button", id: "undo", disabled: !drops.length,
        click: () => set({drop: drops.slice(0, -1).join(",")})}, text("undo")),
      element("span", {}, say("dropped.words", {names: gone}))),
      element("p", {}, text("drop.words")),
      element("div", {class: "row chips", role: "group", "aria-label": text("drop.words")}, ...chips)),
    {style: "grid-column: 1 / -1"}),
    told(text("H.before"), a.before.H, a.before.variables,
      {rest: say("fill.before", {size: a.before.size, count: a.before.non_zeros, null: a.before.null})}),
    told(text("H.after"), a.after.H, a.after.variables, {fill: a.fill, click: drop,
      rest: say("fill.after", {size: a.after.size, count: a.after.non_zeros, filled: a.filled, null: a.after.null})}),
    figure(text("spectrum"), "", chart({series: [{name: text("H.after"), values: a.spectrum, color: "--blue", dots: true}],
      x: text("index"), y: "", label: text("spectrum")})),
    figure(text("density"), "", chart({series: [{name: text("density"), values: a.non_zeros, color: "--blue"}],
      log: false, x: text("drops"), y: "", label: text("density")})),
    Object.assign(figure(text("answers"), text("answers.words"), table(["", "b", "Δx"], [
      [text("before"), numbers(a.before.b), numbers(a.delta_x_before)],
      [text("after"), numbers(a.after.b), numbers(a.delta_x_after)]])),
    {className: a.before.size <= 6 ? "wide" : "", hidden: a.before.size > 6}),
  ];
}

// The frames of a window on the line of all images: filled if a keyframe, ringed if in the prior, with a foot if its
// speed is kept.
function strip(frames, image, label) {
  const svg = element("svg", {viewBox: `0 0 ${WIDTH} 62`, role: "img", "aria-label": label});
  const x = id => 12 + (WIDTH - 24) * id / 29;
  for (let id = 0; id <= 29; ++id) {
    svg.append(element("circle", {cx: x(id), cy: 28, r: 1.5, fill: `var(${id <= image ? "--gray" : "--line"})`}));
    if (id % 5 === 0) svg.append(element("text", {x: x(id), y: 58, "text-anchor": "middle"}, String(id)));
  }
  for (const frame of frames) {
    const at = x(frame.id);
    svg.append(element("rect", {x: at - 5, y: 23, width: 10, height: 10, stroke: "var(--blue)", "stroke-width": 1.5,
      fill: frame.keyframe ? "var(--blue)" : "none"}, element("title", {}, say("frame.n", {n: frame.id}))));
    if (frame.in_prior) svg.append(element("circle", {cx: at, cy: 28, r: 10, fill: "none", stroke: "var(--red)", "stroke-width": 1.5}));
    if (frame.speed) svg.append(element("line", {x1: at, x2: at, y1: 38, y2: 46, stroke: "var(--green)", "stroke-width": 3}));
  }
  return svg;
}

function drawWindow(a) {
  const one = key => {
    const w = a[key];
    const rows = [["landmarks", w.landmarks], ["cost", w.cost],
      ["error", w.position_error], ["prior.size", w.H ? w.H.rows : 0], ["prior.yaw", w.yaw_information]];
    return [
      figure(say("frames.of", {policy: text(key)}), say("frames.words", {count: w.frames.length}),
        strip(w.frames, a.image, text("frames.legend"))),
      w.H ? told(say("prior.of", {policy: text(key)}), w.H, w.variables) : null,
      figure(say("numbers.of", {policy: text(key)}), "", table(["", ""], rows.map(([word, value]) => [text(word), value]))),
    ];
  };
  const path = (key, points, color, hollow) => ({name: text(key), color, hollow, frames: points.map(p => ({p}))});
  const vins = one("vins"), okvis = one("okvis");
  const pairs = vins.flatMap((left, i) => [left, okvis[i]]);
  return [element("p", {class: "legend", style: "grid-column: 1 / -1; margin: 0"}, text("frames.legend")), ...pairs,
    figure(text("flight"), text("flight.words"), scene([path("truth", a.truth.slice(0, a.image + 1), "--gray"),
      path("vins", a.vins.positions.slice(0, a.image + 1), "--blue"),
      path("okvis", a.okvis.positions.slice(0, a.image + 1), "--red")], text("flight")))];
}

const DRAW = {solve: drawSolve, steps: drawSteps, marginalize: drawMarginalize, window: drawWindow};
