// The film of the windows: draws what the tables tell, image by image; the slider of its player says which.
"use strict";
for (const canvas of document.querySelectorAll("canvas.film")) {
  const DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_", SHADES = 10;
  const film = JSON.parse(canvas.dataset.film), words = JSON.parse(canvas.dataset.words);
  const player = canvas.closest(".player"), slider = player.querySelector("input"), pen = canvas.getContext("2d");
  const color = (name) => getComputedStyle(canvas).getPropertyValue(name).trim();
  // The first of these multiples of a power of ten that is as asked.
  const round = (value, multiples, isRight) => multiples.map((one) => one * 10 ** Math.floor(Math.log10(value))).find(isRight);
  const ends = (shot, k) => [Math.min, Math.max].map((most) => most(...shot.frames.map((frame) => frame[k])));
  const spans = (shot) => (shot ? [1, 2].map((k) => ends(shot, k)).map(([low, high]) => high - low) : []);

  const write = (text, x, y) => { pen.fillStyle = color("--ink"); pen.fillText(text, x, y); };

  function line(points, stroke, wide) {
    pen.beginPath();
    for (const point of points) pen.lineTo(...point);
    Object.assign(pen, { strokeStyle: stroke, lineWidth: wide });
    pen.stroke();
  }

  // From above, x to the right, the window in the middle; ellipses hold 95 %. In the corner the whole flight.
  function map(shot, ways, field, left, top, width, height) {
    const scale = Math.min(width, height) / field, bar = round(field / 5, [5, 2, 1], (one) => one <= field / 4.99), way = color(film.true ? "--truth" : "--c0");
    const [middleX, middleY] = [1, 2].map((k) => ends(shot, k).reduce((low, high) => (low + high) / 2));
    const at = ([x, y]) => [left + width / 2 + scale * (x - middleX), top + height / 2 - scale * (y - middleY)];
    pen.save();
    pen.beginPath();
    pen.rect(left, top, width, height);
    pen.clip();
    pen.globalAlpha = film.true ? 1 : 0.35;
    for (const points of ways) line(points.map(at), way, film.true ? 5 : 3);
    pen.globalAlpha = 1;
    overview(ways, field, [middleX, middleY], left + width - height / 3, top, height / 3);
    line(shot.frames.map((frame) => at(frame.slice(1, 3))), color("--c0"), 1.5);
    for (const [gone, x, y, xx, xy, yy, ...truth] of shot.frames) {
      const place = at([x, y]), mean = (xx + yy) / 2, apart = Math.hypot((xx - yy) / 2, xy);
      const radius = (variance) => scale * Math.sqrt(5.99 * Math.max(0, variance));
      Object.assign(pen, { strokeStyle: color(gone ? "--c1" : "--c0"), fillStyle: color(gone ? "--c1" : "--c0"), lineWidth: 1.2 });
      pen.beginPath();
      pen.ellipse(...place, radius(mean + apart), radius(mean - apart), -Math.atan2(2 * xy, xx - yy) / 2, 0, 7);
      pen.stroke();
      pen.beginPath();
      pen.arc(...place, gone ? 5 : 3.5, 0, 7);
      pen.fill();
      if (truth.length) line([place, at(truth)], color("--ink"), 1);  // how far it is from where it truly was
    }
    pen.restore();
    pen.fillStyle = color("--ink");
    pen.fillRect(left, top + height - 3, scale * bar, 2);
    write(`${bar / 1000} m`, left + scale * bar + 6, top + height);
  }

  function overview(ways, field, here, left, top, side) {
    const every = ways.flat(), low = [0, 1].map((k) => Math.min(...every.map((point) => point[k])));
    const spans = [0, 1].map((k) => Math.max(...every.map((point) => point[k])) - low[k]), scale = (side - 12) / Math.max(...spans, 1);
    const at = ([x, y]) => [left + side / 2 + scale * (x - low[0] - spans[0] / 2), top + side / 2 - scale * (y - low[1] - spans[1] / 2)];
    pen.fillStyle = color("--paper");
    pen.fillRect(left, top, side, side);
    Object.assign(pen, { strokeStyle: color("--line"), lineWidth: 1 });
    pen.strokeRect(left, top, side, side);
    for (const points of ways) line(points.map(at), color(film.true ? "--truth" : "--c0"), 1.2);
    const half = Math.max(5, scale * field) / 2, [x, y] = at(here);  // what the map shows
    const [x0, x1] = [x - half, x + half].map((edge) => Math.min(Math.max(edge, left), left + side));
    const [y0, y1] = [y - half, y + half].map((edge) => Math.min(Math.max(edge, top), top + side));
    Object.assign(pen, { strokeStyle: color("--ink"), lineWidth: 1.5 });
    pen.strokeRect(x0, y0, x1 - x0, y1 - y0);
  }

  // Blocks of a matrix in the rows of H, the stronger the larger; fill-in in the color of what has left.
  function matrix(shot, stage, left, top, side) {
    const first = [0];
    for (const count of shot.rows) first.push(first.at(-1) + count);
    const scale = side / first.at(-1), rows = shot.rows;
    pen.strokeStyle = color("--line");
    pen.lineWidth = 1;
    pen.strokeRect(left, top, side, side);
    const at = (k) => DIGITS.indexOf(shot[stage][k]), vertex = (k) => (film.letters === 1 ? at(k) : DIGITS.length * at(k) + at(k + 1));
    for (let k = 0, i = 0; k < shot[stage].length; k += film.letters + 1) {
      if (shot[stage][k] === ".") {  // a row begins
        i = vertex(k + 1);
        continue;
      }
      const j = vertex(k), digit = at(k + film.letters);
      const fill = digit > SHADES;
      pen.fillStyle = color(fill ? "--c1" : "--c0");
      pen.globalAlpha = 0.15 + 0.85 * (fill ? digit - SHADES : digit) / SHADES;
      for (const [a, b] of i === j ? [[i, j]] : [[i, j], [j, i]]) {
        pen.fillRect(left + scale * first[b], top + scale * first[a], scale * rows[b], scale * rows[a]);
      }
    }
    pen.fillStyle = color(stage === "window" ? "--c1" : "--pale");
    shot.gone.forEach((gone, i) => {
      if (!gone) return;
      pen.globalAlpha = stage === "window" ? 0.35 : 1;
      pen.fillRect(left, top + scale * first[i], side, scale * rows[i]);
      pen.fillRect(left + scale * first[i], top, scale * rows[i], side);
    });
    pen.globalAlpha = 1;
  }

  function draw() {
    const width = player.clientWidth - 32, narrow = width < 640, gap = 14;
    const side = narrow ? (width - gap) / 2 : Math.min(300, (width - 2 * gap) / 3), wide = narrow ? width : width - 2 * (side + gap);
    const each = narrow ? 2 * side + 64 : side + 34;
    if (side <= 0 || wide <= 0) return;  // not laid out yet
    const sharp = devicePixelRatio || 1;
    canvas.width = sharp * width;
    const tall = each * Object.keys(film.names).length;
    canvas.height = sharp * tall;
    canvas.style.height = `${tall}px`;
    pen.scale(sharp, sharp);
    pen.font = `${narrow ? 12 : 14}px system-ui, sans-serif`;
    // Both maps have one scale, by steps so that it seldom changes, in which the larger window fits.
    const most = 1.25 * Math.max(200, ...Object.values(film.shots).flatMap((every) => spans(every[slider.value])));
    const field = round(most, [1, 1.5, 2, 3, 5, 7, 10], (one) => one >= most);
    Object.keys(film.names).forEach((policy, k) => {
      const shot = film.shots[policy][slider.value], top = k * each + 22, below = narrow ? top + side + 30 : top;
      const right = narrow ? 0 : wide + gap;
      write(film.names[policy] + words.above, 0, top - 6);
      if (!shot) return;  // the policy has no prior yet, or the truth has a gap
      map(shot, film.ways[policy], field, 0, top, wide, side);
      ["window", "prior"].forEach((stage, at) => {
        write(words[stage], right + at * (side + gap), below - 6);
        matrix(shot, stage, right + at * (side + gap), below, side);
      });
    });
  }

  const go = (by) => {
    const images = Number(slider.max) + 1;
    slider.value = (Number(slider.value) + by + images) % images;
    slider.dispatchEvent(new Event("input"));
  };
  let playing = null;
  const button = (label, act) => {
    const made = document.createElement("button");
    Object.assign(made, { type: "button", textContent: label, onclick: act });
    slider.after(made);
    return made;
  };
  const stop = () => { clearInterval(playing); playing = null; play.textContent = words.play; };
  button(words.on, () => { stop(); go(1); });
  const play = button(words.play, () => {
    if (playing) return stop();
    playing = setInterval(() => go(1), 200);
    play.textContent = words.pause;
  });
  button(words.back, () => { stop(); go(-1); });
  slider.addEventListener("input", draw);
  addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
}
