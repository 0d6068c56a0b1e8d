"use strict";
// Elimination as a game: what is left of the factor graph, and the Bayes net that takes its place.

const RADIUS = 17;  // of a variable; a finger needs 24 pixels on a phone

// A line between two variables, from rim to rim; with a head at its end if it is an arrow.
function tie([x1, y1], [x2, y2], attributes, isArrow = false) {
  const length = Math.hypot(x2 - x1, y2 - y1), [ux, uy] = [(x2 - x1) / length, (y2 - y1) / length];
  const [bx, by, ex, ey] = [x1 + RADIUS * ux, y1 + RADIUS * uy, x2 - RADIUS * ux, y2 - RADIUS * uy];
  const corner = side => `${ex - 11 * ux - side * 5 * uy} ${ey - 11 * uy + side * 5 * ux}`;
  return element("path", {fill: "none", "stroke-width": 2, ...attributes,
    d: `M${bx} ${by}L${ex} ${ey}` + (isArrow ? `M${corner(1)}L${ex} ${ey}L${corner(-1)}` : "")});
}

function variableShape(kind, [x, y], paint) {
  if (kind !== "pose") return element("circle", {cx: x, cy: y, r: RADIUS, ...paint});
  return element("rect", {x: x - RADIUS, y: y - RADIUS, width: 2 * RADIUS, height: 2 * RADIUS, rx: 3, ...paint});
}

function gameFigure(a, eliminate) {
  const names = new Map(a.L_variables.map(one => [one.number, one])), at = number => [SIDE * a.nodes[number].x, SIDE * a.nodes[number].y];
  const isLeft = number => a.left.some(one => one.number === number), last = a.gone.at(-1);
  const svg = element("svg", {viewBox: `0 0 ${SIDE} ${SIDE + 16}`, role: "group", "aria-label": text("board.label"), class: "game"});
  const place = element("g", {transform: "translate(0 16)"}), list = numbers => numbers.map(one => name(names.get(one))).join(text("comma")) || text("nobody");
  for (const {i, j, fill} of a.ties) {
    place.append(tie(at(i), at(j), {stroke: `var(${fill ? "--amber" : "--gray"})`, "stroke-dasharray": fill ? "6 4" : undefined}));
  }
  for (const {i, j} of a.factors.filter(one => isLeft(one.i) && isLeft(one.j))) {
    const [x, y] = i === j ? [at(i)[0], at(i)[1] - RADIUS - 9] : [0, 1].map(axis => (at(i)[axis] + at(j)[axis]) / 2);
    if (i === j) place.append(element("path", {d: `M${x} ${y}v9`, stroke: "var(--gray)", "stroke-width": 2}));
    place.append(element("rect", {x: x - 4, y: y - 4, width: 8, height: 8, fill: "var(--ink)"}));
  }
  for (const {number, clique} of a.gone) clique.forEach(one => place.append(tie(at(one), at(number), {stroke: "var(--orange)"}, true)));
  const words = last ? say("game.last", {name: name(names.get(last.number)), clique: list(last.clique)}) : text("game.first");
  const box = figure("game", text("game"), words), tell = said => { box.lastChild.textContent = said; };
  for (const {number, kind} of a.L_variables) {
    const left = a.left.find(one => one.number === number), clique = (left || a.gone.find(one => one.number === number)).clique;
    const said = say(left ? "game.left" : "game.gone", {name: name({kind, number}), clique: list(clique), fill: left?.fill});
    const inClique = last && last.clique.includes(number), paint = `var(${left ? "--blue" : "--orange"})`;
    const node = element("g", {tabindex: 0, role: "button", id: `variable-${number}`, "aria-label": said, "aria-disabled": String(!left),
      "data-item": `variable ${number}`, class: inClique ? "clique" : undefined},
    variableShape(kind, at(number), {fill: "var(--paper)", stroke: paint, "stroke-width": inClique ? 5 : 2.5}),
    element("text", {x: at(number)[0], y: at(number)[1] + 5, "text-anchor": "middle"}, name({kind, number}).split(" ").at(-1)));
    const act = () => { if (left) eliminate(number); };
    const show = on => {
      tell(on ? said : words);
      for (const other of svg.querySelectorAll("[data-item]")) {
        other.classList.toggle("lit", on && [number, ...clique].some(one => other.dataset.item === `variable ${one}`));
      }
    };
    node.addEventListener("click", act);
    node.addEventListener("keydown", event => {
      if (!["Enter", " "].includes(event.key)) return;
      event.preventDefault();
      act();
    });
    for (const [event, on] of [["pointerenter", true], ["focus", true], ["pointerleave", false], ["blur", false]]) {
      node.addEventListener(event, () => show(on));
    }
    place.append(node);
  }
  svg.append(place, ...legend([{name: text("game.key.left"), color: "--blue", hollow: true}, {name: text("game.key.gone"), color: "--orange", hollow: true},
    {name: text("game.key.fill"), color: "--amber"}]));
  box.insertBefore(svg, box.lastChild);
  box.lastChild.setAttribute("aria-live", "polite");
  return box;
}

function drawEliminate(a, values, set) {
  const order = values.order ? values.order.split(",") : [], go = numbers => set({order: numbers.join(",")});
  const eliminate = number => go([...order, number]);
  const button = (id, off, numbers) => element("button", {type: "button", id, disabled: off, click: () => go(numbers)}, text(id));
  const isOver = !a.left.length, key = !isOver ? "open" : a.fill < a.amd ? "won" : a.fill === a.amd ? "even" : "lost";
  return [
    element("div", {class: "wide", "data-key": "score"},
      element("div", {class: "row"}, button("undo", !order.length, order.slice(0, -1)), button("restart", !order.length, []),
        button("by-amd", false, a.amd_order)),
      element("p", {id: "score", role: "status", class: key === "won" ? "good" : undefined},
        say("score", {fill: a.fill, amd: a.amd, least: a.least}), " ", text(`score.${key}`))),
    gameFigure(a, eliminate),
    told("L", text("L"), a.L, a.L_variables, {fill: a.L_fill, rest: text("L.words")}),
    a.left.length ? told("H.after", text("H.left"), a.H, a.H_variables, {fill: a.H_fill.rows ? a.H_fill : null, rest: text("H.left.words"),
      act: (row, column) => eliminate(a.left[Math.max(row, column)].number)}) : null,
  ];
}

const DRAW = {solve: drawSolve, steps: drawSteps, marginalize: drawMarginalize, window: drawWindow, eliminate: drawEliminate};
