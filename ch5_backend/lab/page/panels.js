"use strict";
// What each panel shows of an answer. `set` changes settings, as a slider does.

const name = one => one.kind === "extrinsic" ? one.kind : say(`${one.kind}.n`, {n: one.number});

// A matrix with a line below it that tells the entry under the pointer, which lights up its part of the scene.
function told(key, title, M, variables, {rest, id = `matrix-${key}`, ...options} = {}) {
  const words = rest || say("matrix.size", {rows: M.rows, cols: M.cols});
  const box = figure(key, title, words), line = box.lastChild;
  const tell = (row, column) => {
    const [a, b] = row < 0 ? [] : [row, column].map(at => variables[variableAt(variables, at)]);
    light(box.closest("#beside, #pictures") || box, [a, b]);
    const pair = a && b ? `${name(a)} × ${name(b)}: ` : "";
    line.textContent = row < 0 ? words : `${pair}(${row}, ${column}) = ${short(M.values[row * M.cols + column])}`;
  };
  line.setAttribute("aria-live", "polite");
  box.insertBefore(matrix(M, {variables, tell, id, label: `${[title].flat().map(one => one.textContent ?? one).join("")}. ${words} ${text("matrix.keys")}`, ...options}), line);
  return box;
}

function views(answer, layers) {
  return [
    {name: text("truth"), color: "--gray", key: "truth", ...answer.truth},
    ...layers.filter(one => one[1]).map(([key, value, color, hollow]) => ({name: text(key), color, hollow, key, ...value})),
  ];
}

const posesOf = variables => variables.filter(one => one.kind === "pose" && one.row >= 0);

// "2:0.5:-1,4:0:0.3" with (dx, dy) added to the shift of `number`.
function shifted(items, number, dx, dy) {
  const all = new Map(items.split(",").filter(Boolean).map(one => [one.split(":")[0], one.split(":").slice(1).map(Number)]));
  const [x, y] = all.get(String(number)) || [0, 0];
  const keep = value => Number(Math.min(20, Math.max(-20, value)).toFixed(3));
  all.set(String(number), [keep(x + dx), keep(y + dy)]);
  return [...all].map(one => one.flat().join(":")).join(",");
}

// Each landmark that is seen in other frames is seen by its host, frame 0, too.
function raysOf({rows, cols, values}) {
  const rays = [];
  for (let k = 0; k < cols; ++k) {
    const seen = Array.from({length: rows}, (_, n) => n).filter(n => n > 0 && values[n * cols + k] !== null);
    if (seen.length) rays.push(...[0, ...seen].map(n => [k, n]));
  }
  return rays;
}

function sceneFigure(a, layers, caption, values, set) {
  const shown = views(a, layers), isStart = state.drag === "start";
  const layer = shown.find(one => one.key === (isStart ? "start.states" : "truth"));
  const move = (kind, number, dx, dy) => {
    const setting = (kind === "pose" ? "camera" : "landmark") + (isStart ? "_starts" : "s");
    set({[setting]: shifted(state.values[setting], number, dx, dy)});  // several moves may come before a picture
  };
  const modes = ["scene", "start"].map(one => element("button", {type: "button", id: `drag-${one}`,
    "aria-pressed": String(one === (isStart ? "start" : "scene")), click: () => { state.drag = one; set({}); }}, text(`drag.${one}`)));
  const moved = DRAGGED.slice(0, 4).some(one => values[one]);
  return figure("scene", text("scene"), caption,
    element("div", {class: "row chips", role: "group", "aria-label": text("drag")}, element("span", {}, text("drag")), ...modes,
      element("button", {type: "button", id: "drag-back", disabled: !moved,
        click: () => set(Object.fromEntries(DRAGGED.slice(0, 4).map(one => [one, ""])))}, text("drag.back"))),
    scene(shown, {label: text("scene.label"), truth: a.truth, rays: a.residuals ? raysOf(a.residuals) : [], drag: {layer, move}}));
}

// Who sees what: a row for each frame after the host, a column for each landmark, stronger the larger the residual.
function observations(a, values, set) {
  const {rows, cols} = a.residuals, count = rows - 1, wide = Math.max(cols, 12);
  const at = (n, k) => a.residuals.values[n * cols + k];
  const [, largest] = commonRange("observations", [0, Math.max(1e-300, ...a.residuals.values.map(value => value || 0))]);
  const cellSize = Math.floor(960 / wide);
  const canvas = element("canvas", {width: cellSize * cols, height: cellSize * count, role: "application", tabindex: 0,
    "aria-label": text("observations.label"), class: "grid", id: "observations"});
  const context = canvas.getContext("2d");
  const [blue, line, soft] = ["--blue", "--line", "--soft"].map(color);
  context.lineWidth = 3;
  for (let n = 1; n < rows; ++n) {
    for (let k = 0; k < cols; ++k) {
      const [x, y] = [cellSize * k, cellSize * (n - 1)], value = at(n, k);
      [context.strokeStyle, context.fillStyle, context.globalAlpha] = [line, blue, 1];
      context.strokeRect(x, y, cellSize, cellSize);
      if (value === null) {
        context.strokeStyle = soft;
        context.beginPath();
        for (const [from, to] of [[0.25, 0.75], [0.75, 0.25]]) {
          context.moveTo(x + 0.25 * cellSize, y + from * cellSize);
          context.lineTo(x + 0.75 * cellSize, y + to * cellSize);
        }
        context.stroke();
      } else {
        context.globalAlpha = 0.1 + 0.9 * value / largest;
        context.fillRect(x + 3, y + 3, cellSize - 6, cellSize - 6);
      }
    }
  }
  const words = text("observations.words"), box = figure("observations", text("observations"), words, canvas);
  box.lastChild.setAttribute("aria-live", "polite");
  const tell = (row, k) => {
    light(box.closest("#beside, #pictures") || box, row < 0 ? [] : [{kind: "pose", number: row + 1}, {kind: "landmark", number: k}]);
    const value = row < 0 ? null : at(row + 1, k);
    box.lastChild.textContent = row < 0 ? words : say(value === null ? "observation.out" : "observation.in",
      {landmark: k, frame: row + 1, residual: short(value)});
  };
  const toggle = (row, k) => {
    const key = `${k}:${row + 1}`, out = values.without.split(",").filter(Boolean);
    set({without: (out.includes(key) ? out.filter(one => one !== key) : [...out, key]).join(",")});
  };
  const blocksOf = length => Array.from({length}, (_, row) => ({row, rows: 1}));
  explore(canvas, [count, cols], [blocksOf(count), blocksOf(cols)], tell, toggle);
  return box;
}

// Ellipses of what is claimed of x and y and where the truth lies, enlarged alike about the estimate; `at` places a point of the
// world, whose meter has so many pixels.
function ellipsesOf({claims, claim_limit: limit}, at, pixels, times) {
  return claims.flatMap(({p, error, covariance: [xx, xy, , yy], chi2}) => {
    const half = (xx + yy) / 2, root = Math.hypot((xx - yy) / 2, xy);
    const [rx, ry] = [half + root, Math.max(half - root, 0)].map(one => times * pixels * Math.sqrt(limit * one));
    const [[cx, cy], [x, y]] = [p, [p[0] + times * error[0], p[1] + times * error[1]]].map(at);
    const turn = `rotate(${-90 / Math.PI * Math.atan2(2 * xy, xx - yy)} ${cx} ${cy})`, isOut = chi2 > limit;
    return [element("ellipse", {cx, cy, rx, ry, transform: turn, fill: "none", stroke: "var(--blue)", "stroke-width": 2}),
      element("path", {d: `M${cx} ${cy}L${x} ${y}`, stroke: "var(--gray)"}), element("circle", {cx, cy, r: 3, fill: "var(--blue)"}),
      element("circle", {cx: x, cy: y, r: isOut ? 7 : 4, class: isOut ? "out" : undefined, ...paintOf({hollow: isOut, color: isOut ? "--red" : "--gray"})})];
  });
}

const claimedOf = a => (a.claims || []).filter(one => isFinitePoint(one.p));

// 1, 2 or 5 times a power of ten, so that no ellipse and no error is longer than `room` [m].
function enlargement(claims, limit, room) {
  const [, most] = commonRange("claims", [0, Math.max(...claims.map(({error, covariance: [xx, xy, , yy]}) =>
    Math.max(Math.sqrt(limit * ((xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy))), Math.hypot(...error))))]);
  const decade = 10 ** Math.floor(Math.log10(room / most));
  return Number((decade * [5, 2, 1].find(one => one * decade <= room / most)).toPrecision(1));
}

function claimsFigure(title, a, claims, times, drawing) {
  drawing.append(...legend([{name: text("estimate"), color: "--blue"}, {name: text("truth"), color: "--gray"}, {name: text("claims.out"), color: "--red", hollow: true}]));
  return figure("claims", title, say("claims.words", {times, out: claims.filter(one => one.chi2 > a.claim_limit).length, all: claims.length}), drawing);
}

function claims(a) {
  const claimed = claimedOf(a);
  if (!claimed.length) return figure("claims", text("claims"), text("claims.none"));
  const times = enlargement(claimed, a.claim_limit, 0.35 * SIDE / PIXELS / Math.max(2, claimed.length));
  const svg = element("svg", {viewBox: `0 0 ${SIDE} ${SIDE + 16}`, role: "img", "aria-label": text("claims"), class: "game"});
  svg.append(...ellipsesOf({...a, claims: claimed}, toPicture, PIXELS, times));
  return claimsFigure(text("claims"), a, claimed, times, svg);
}

// The same of the windows of both policies: maps of one scale, about each window's middle.
function claimsOfWindows(a, keys) {
  const all = keys.map(key => claimedOf(a[key])), axes = [0, 1], placed = k => [a[keys[k]].held, ...all[k].map(one => one.p)];
  if (all.some(one => !one.length)) return keys.map(() => null);
  const range = (k, axis) => [Math.min, Math.max].map(most => most(...placed(k).map(p => p[axis])));
  const spans = all.map((_, k) => axes.map(axis => range(k, axis)[1] - range(k, axis)[0]));
  const pixels = Math.min(...spans.map(([x, y]) => Math.min((WIDTH - 120) / Math.max(x, 0.05), (HEIGHT - 120) / Math.max(y, 0.05))));
  const times = enlargement(all.flat(), a[keys[0]].claim_limit, 46 / pixels);
  return keys.map((key, k) => {
    const title = say("claims.of", {policy: text(key)}), svg = element("svg", {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title});
    const [mx, my] = axes.map(axis => range(k, axis).reduce((sum, end) => sum + end / 2, 0));
    const at = p => [WIDTH / 2 + pixels * (p[0] - mx), (HEIGHT + 20) / 2 - pixels * (p[1] - my)], [x, y] = at(a[key].held);
    svg.append(element("path", {d: "M" + placed(k).map(p => at(p).join(" ")).join("L"), fill: "none", stroke: "var(--line)", "stroke-width": 2}),
      element("circle", {cx: x, cy: y, r: 4, fill: "var(--gray)"}), ...ellipsesOf({...a[key], claims: all[k]}, at, pixels, times), ...scaleBar(WIDTH, HEIGHT, pixels));
    return claimsFigure(title, a[key], all[k], times, svg);
  });
}

function drawSolve(a, values, set) {
  const trace = a.trace;
  const spectra = [{name: "H", values: a.spectrum_H, color: "--blue", dots: true}];
  if (a.spectrum_S) spectra.push({name: "S", values: a.spectrum_S, color: "--ink", dots: true});
  return [
    sceneFigure(a, [["start.states", a.start, "--pale", true], ["estimate", a.estimate, "--blue", false]],
      say("scene.words", {at: short(a.rmse_position), aligned: short(a.rmse_position_aligned), points: short(a.rmse_point)}), values, set),
    claims(a),
    told("H", text("H"), a.H, a.variables.filter(one => one.row >= 0)),
    a.S.rows ? told("S", text("S"), a.S, posesOf(a.variables)) : null,
    observations(a, values, set),
    figure("cost", text("cost"), say("cost.words", {iterations: a.iterations, end: text("end." + a.termination)}),
      chart({series: [{name: text("cost"), values: trace.map(row => row.cost), color: "--blue"},
        {name: "λ", values: trace.map((row, i) => i ? row.lambda : null), color: "--orange", dashed: true}],
        x: text("iteration"), y: "", label: text("cost")}),
      lines(formula("F = ½ Σ ρ(r^T W r)"),
        formula(`= ${number(a.observation_cost)} + ${number(a.prior_cost)}`), formula(`= ${number(a.final_cost)}`))),
    figure("spectrum", text("spectrum"), say("spectrum.words", {H: a.null_H, S: a.null_S ?? 0}),
      chart({series: spectra, x: text("index"), y: "", label: text("spectrum")})),
  ];
}

const STOPS = ["linearize", "build", "damp", "eliminate", "solve", "step", "judge"];

// The present step in symbols and in the numbers of this trial: one observation, one row, one landmark stand for all.
function stepFormulas(a, {stop, algorithm}) {
  const row = a.trials[a.trial], {landmark, frame, r, W, J_landmark: Jl, J_pose: Jp} = a.observation || {};
  const n = a.H.rows, H = (i, j) => a.H.values[i * n + j], dims = a.pose_rows;
  const l = a.variables.find(one => one.kind === "landmark" && one.number === landmark);
  const pose = a.variables.find(one => one.kind === "pose" && one.number === frame);
  const at = l ? l.row : -1, pr = pose ? pose.row : -1, k = landmark;
  const sum = (values, f) => values.reduce((total, value, i) => total + f(value, i), 0);
  switch (stop) {
    case "linearize": return !r ? [] : [
      formula(`r_{${k},${frame}} = π(x) − z =`, brackets(r, 1)),
      formula(`J_λ = ∂r/∂λ_${k} =`, brackets(Jl.values, 1), `, J_${frame} = ∂r/∂x_${frame} =`, brackets(Jp.values, Jp.cols))];
    case "build": return !r || at < 0 ? [] : [
      formula(`J_λ^T W J_λ = ${number(W)} ·`, brackets(Jl.values, 2), brackets(Jl.values, 1),
        `= ${number(W * sum(Jl.values, one => one * one))}`),
      formula(`H_{λλ} = Σ_j J_λ^T W_ρ J_λ = ${number(H(at, at))}`),
      formula(`b_λ = −Σ_j ρ^′ J_λ^T W r = ${number(a.b[at])}`)];
    case "damp": return [formula(`H_{00} + λ D_{00} = ${number(H(0, 0))} + ${number(a.damping[0])} = ${number(H(0, 0) + a.damping[0])}`)];
    case "eliminate": return !a.S.rows || dims === n ? [] : [formula("S = H_pp − H_pm H_mm^{−1} H_mp"),
      formula(`S_{00} = ${number(H(0, 0) + a.damping[0])} − ${number(H(0, 0) + a.damping[0] - a.S.values[0])} = ${number(a.S.values[0])}`)];
    case "solve": {
      if (!row.solved || at < 0) return [];
      const Hx = sum(a.delta_x.slice(0, dims), (value, i) => H(at, i) * value), damped = H(at, at) + a.damping[at];
      const lines = [formula("S Δx_p = b_p − H_pm H_mm^{−1} b_m"), formula(`H_mm Δx_m = b_m − H_mp Δx_p`)];
      if (algorithm === "dogleg") return lines;  // whose step is another one
      return [...lines, formula(`Δλ_${k} =`, fraction(`${number(a.b[at])} − ${inner(Hx)}`, number(damped)), `= ${number(a.delta_x[at])}`)];
    }
    case "step": {
      if (!row.solved || pr < 0) return [];
      const [before, after] = [a.linearized_at, a.moved_to].map(states => states.frames[frame].p);
      return [formula(`x_${frame} ⊞ Δx_${frame} :  p + δp =`, brackets(before, 1), "+",
        brackets(after.map((value, i) => value - before[i]), 1), "=", brackets(after, 1))];
    }
    default: return !row.solved ? [] : [formula("ρ =", fraction("F(x) − F(x ⊞ Δx)", "F(x) − m(Δx)"), "=",
      fraction(number(row.decrease), number(row.predicted)), row.gain === undefined ? "" : `= ${number(row.gain)}`)];
  }
}

function stopPictures(a, stop, values, set) {
  const row = a.trials[a.trial], variables = a.variables.filter(one => one.row >= 0);
  const H = () => told("H", text("H"), a.H, variables);
  const from = ["linearized_at", a.linearized_at, "--blue", true], begin = ["start.states", a.start, "--pale", true];
  const moved = layers => sceneFigure(a, [begin, ...layers], "", values, set);
  const vector = (title, values) => figure(title, text(title), text("rows.words"), bars(values, a.pose_rows, text(title)));
  switch (stop) {
    case "linearize": return [moved([from])];
    case "build": return [moved([from]), H(), vector("b", a.b)];
    case "damp": return [H(), figure("diagonal", text("diagonal"), say("damp.words", {lambda: short(row.lambda)}), chart({
      series: [{name: "diag H", values: a.H.values.filter((_, i) => i % (a.H.rows + 1) === 0), color: "--blue", dots: true},
        {name: "λD", values: a.damping, color: "--orange", dots: true}], x: text("index"), y: "", label: text("diagonal")}))];
    case "eliminate": return [moved([from]), H(), told("S.damped", text("S.damped"), a.S, posesOf(a.variables))];
    case "solve": return row.solved ? [vector("delta_x", a.delta_x)] : [element("p", {class: "bad"}, text("unsolved"))];
    case "step": return [moved([from, ["moved_to", a.moved_to, "--blue", false]])];
    default: return [];
  }
}

function drawSteps(a, values, set) {
  if (!a.trials.length) return [element("p", {}, text("end." + a.termination))];
  const stop = values.stop, at = STOPS.indexOf(stop), row = a.trials[a.trial];
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
  const numbers = stepFormulas(a, values);
  return [
    element("div", {class: "wide", "data-key": "loop"}, element("div", {class: "row"}, button("back", -1, a.trial === 0 && at === 0),
      button("forward", 1, a.trial === a.trials.length - 1 && at === STOPS.length - 1),
      element("strong", {}, say("trial.words", {trial: a.trial + 1, trials: a.trials.length, iteration: row.iteration}))),
    element("div", {class: "row", role: "group", "aria-label": text("stops")}, ...stops),
    element("p", {id: "formula"}, ...rich(`formula.${stop}`)),
    numbers.length ? lines(...numbers) : null),
    ...stopPictures(a, stop, values, set),
    Object.assign(figure("trials", text("trials"), say("end.words", {end: text("end." + a.termination)}),
      table(heads, stop === "judge" ? rows : rows.slice(0, a.trial), stop === "judge" ? a.trial : -1)), {className: "wide"}),
  ];
}

// H_prior of a system that can be worked out on paper, in numbers.
function marginalizeFormulas(a) {
  const symbols = formula("H_prior = H_rr − H_rm H_mm^{−1} H_mr,  b_prior = b_r − H_rm H_mm^{−1} b_m");
  if (!a.last || a.last.H.rows > 6) return [symbols];
  const {H, row, b} = a.last, size = H.rows, rest = Array.from({length: size}, (_, i) => i).filter(i => i !== row);
  const pick = (rows, columns) => rows.flatMap(i => columns.map(j => H.values[i * size + j]));
  const column = pick(rest, [row]), pivot = H.values[row * size + row];
  return [symbols, formula("H_prior =", brackets(pick(rest, rest), rest.length), "−", fraction("1", number(pivot)),
    brackets(column, 1), brackets(column, column.length), "=", brackets(a.after.H.values, rest.length)),
  formula("b_prior =", brackets(rest.map(i => b[i]), 1), "−", fraction(number(b[row]), number(pivot)), brackets(column, 1), "=",
    brackets(a.after.b, 1))];
}

function drawMarginalize(a, values, set) {
  const drops = values.drop ? values.drop.split(",") : [];
  const drop = position => { if (position >= 0 && a.after.variables.length > 1) set({drop: [...drops, position].join(",")}); };
  const chips = a.after.variables.map((one, i) => element("button", {type: "button", id: `drop-${i}`, click: () => drop(i)}, name(one)));
  const gone = a.dropped.map(name).join(text("comma")) || text("nothing");
  const numbers = values => values.length <= 6 ? `(${values.map(short).join(", ")})` : "";
  const act = (row, column) => drop(variableAt(a.after.variables, Math.max(row, column)));
  return [
    element("div", {class: "wide", "data-key": "drop"},
      element("div", {class: "row"}, element("button", {type: "button", id: "undo", disabled: !drops.length,
        click: () => set({drop: drops.slice(0, -1).join(",")})}, text("undo")),
      element("span", {}, say("dropped.words", {names: gone}))),
      element("p", {}, text("drop.words")),
      element("div", {class: "row chips", role: "group", "aria-label": text("drop.words")}, ...chips)),
    drops.length ? element("div", {class: "wide"}, lines(...marginalizeFormulas(a))) : null,
    told("H.before", text("H.before"), a.before.H, a.before.variables,
      {rest: say("fill.before", {size: a.before.size, count: a.before.non_zeros, null: a.before.null})}),
    told("H.after", text("H.after"), a.after.H, a.after.variables, {fill: a.fill, act,
      rest: say("fill.after", {size: a.after.size, count: a.after.non_zeros, filled: a.filled, null: a.after.null})}),
    figure("spectrum", text("spectrum"), "", chart({series: [{name: text("H.after"), values: a.spectrum, color: "--blue", dots: true}],
      x: text("index"), y: "", label: text("spectrum")})),
    figure("density", text("density"), "", chart({series: [{name: text("density"), values: a.non_zeros, color: "--blue"}],
      log: false, x: text("drops"), y: "", label: text("density")})),
    Object.assign(figure("answers", text("answers"), text("answers.words"), table(["", "b", "Δx"], [
      [text("before"), numbers(a.before.b), numbers(a.delta_x_before)],
      [text("after"), numbers(a.after.b), numbers(a.delta_x_after)]])),
    {className: a.before.size <= 6 ? "wide" : "", hidden: a.before.size > 6}),
  ];
}

// The frames of a window on the line of all images: filled if a keyframe, ringed if in the prior, with a foot if its
// speed is kept.
function strip(frames, image, label) {
  const svg = element("svg", {viewBox: "0 0 420 62", role: "img", "aria-label": label});
  const x = id => 12 + 396 * id / 29;
  for (let id = 0; id <= 29; ++id) {
    svg.append(element("circle", {cx: x(id), cy: 28, r: 1.5, fill: `var(${id <= image ? "--gray" : "--line"})`}));
    if (id % 5 === 0) svg.append(element("text", {x: x(id), y: 58, "text-anchor": "middle"}, String(id)));
  }
  for (const frame of frames) {
    const at = x(frame.id);
    svg.append(element("rect", {x: at - 5, y: 23, width: 10, height: 10, stroke: "var(--blue)", "stroke-width": 1.5,
      fill: frame.keyframe ? "var(--blue)" : "none"}, element("title", {}, say("frame.n", {n: frame.id}))));
    if (frame.in_prior) svg.append(element("circle", {cx: at, cy: 28, r: 10, fill: "none", stroke: "var(--orange)", "stroke-width": 1.5}));
    if (frame.speed) svg.append(element("line", {x1: at, x2: at, y1: 38, y2: 46, stroke: "var(--green)", "stroke-width": 3}));
  }
  return svg;
}

function drawWindow(a) {
  const largest = Math.max(...["vins", "okvis"].map(key => a[key].H ? largestOf(a[key].H) : 0));
  const one = key => {
    const w = a[key];
    const rows = [["landmarks", w.landmarks], ["cost", w.cost],
      ["error", w.position_error], ["prior.size", w.H ? w.H.rows : 0], ["prior.yaw", w.yaw_information]];
    return [
      figure("frames.of", say("frames.of", {policy: text(key)}), say("frames.words", {count: w.frames.length}),
        strip(w.frames, a.image, text("frames.legend"))),
      w.H ? told("prior.of", say("prior.of", {policy: text(key)}), w.H, w.variables, {id: `matrix-prior-${key}`, largest}) : null,
      figure("numbers.of", say("numbers.of", {policy: text(key)}), "", table(["", ""], rows.map(([word, value]) => [text(word), value]))),
    ];
  };
  const path = (key, points, color, hollow) => ({name: text(key), color, hollow, points: points.slice(0, a.image + 1)});
  const vins = one("vins"), okvis = one("okvis");
  const pairs = [...vins.flatMap((left, i) => [left, okvis[i]]), ...claimsOfWindows(a, ["vins", "okvis"])];
  return [element("p", {class: "legend wide"}, text("frames.legend")), ...pairs,
    figure("flight", text("flight"), text("flight.words"), trajectories([path("truth", a.truth, "--gray"),
      path("vins", a.vins.positions, "--blue"), path("okvis", a.okvis.positions, "--blue", true)], text("flight")))];
}
