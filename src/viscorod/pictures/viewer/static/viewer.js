"use strict";
/* The page: reads the data, connects player, view and charts. */

viscorod.Player = class {
  constructor(x, rate, show) {
    this.x = x; // instants of the frames, increasing
    this.rate = rate; // of x per second of the reader
    this.show = show;
    this.repeat = true;
    this.playing = false;
    this.at = x[0];
    this.within(0, x.length - 1);
  }

  /* Play between two frames only. */
  within(first, last) {
    [this.first, this.last] = [this.x[first], this.x[last]];
    [this.from, this.to] = [first, last];
  }

  /* The frame at or before an instant, and the part of the way to the next. */
  frame(x) {
    let [low, high] = [0, this.x.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.x[middle] <= x) low = middle;
      else high = middle;
    }
    if (high === 0) return [0, 0];
    if (x >= this.x[high]) return [high, 0];
    const gap = this.x[high] - this.x[low];
    return [low, gap > 0 ? Math.max(0, (x - this.x[low]) / gap) : 0];
  }

  goTo(x) {
    this.at = Math.min(Math.max(x, this.first), this.last);
    this.show(this.at, ...this.frame(this.at));
  }

  step(count) {
    const [k, part] = this.frame(this.at);
    const from = count < 0 && part > 0 ? k + 1 : k;
    this.goTo(this.x[Math.min(Math.max(from + count, this.from), this.to)]);
  }

  play(on) {
    if (this.playing === on || this.x.length < 2) return;
    this.playing = on;
    if (!on) return;
    if (this.at >= this.last) this.at = this.first;
    let before = null;
    const tick = (now) => {
      if (!this.playing) return;
      const { first, last } = this;
      if (before !== null) {
        let next = this.at + (this.rate * Math.min(now - before, 250)) / 1000;
        if (next >= last) {
          next = this.repeat ? first + ((next - first) % (last - first)) : last;
          if (!this.repeat) this.ended();
        }
        this.goTo(next);
      }
      before = now;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  ended() {
    this.playing = false;
  }
};

viscorod.increasing = (values) => values.every((value, k) => k === 0 || value > values[k - 1]);

viscorod.speeds = function (span, timed) {
  const best = timed && span >= 2 && span <= 40 ? 1 : timed ? span / 8 : 1;
  const power = Math.floor(Math.log10(best));
  const rounds = [];
  for (let p = power - 2; p <= power + 2; p++) for (const d of [1, 2, 5]) rounds.push(Number((d * 10 ** p).toPrecision(3)));
  const chosen = rounds.reduce((a, b) => (Math.abs(Math.log(b / best)) < Math.abs(Math.log(a / best)) ? b : a));
  return { options: rounds.filter((r) => r >= 0.01 * chosen && r <= 100 * chosen), chosen };
};

viscorod.start = async function () {
  const $ = (id) => document.getElementById(id);
  const { meta, arrays } = await viscorod.read();
  const timed = meta.dimension === "time";
  const [clock, second] = meta.clock; // short motions are told in ms or µs
  const told = (values) => Float64Array.from(values, (value) => clock * value);
  const instants = told(arrays.instants.values);
  const samples = told(arrays.samples.values);
  $("title").textContent = meta.title || meta.heading;
  const version = meta.version ? `viscorod ${meta.version}` : "viscorod";
  $("notes").textContent = [...meta.notes, version].join(" \u00b7 ");
  const warnings = [...(meta.outcome === "completed" ? [] : [`outcome: ${meta.outcome}`]), ...meta.warnings];
  if (warnings.length) {
    $("warnings").hidden = false;
    $("warnings").querySelector("summary").textContent = warnings.length === 1 ? "1 warning" : `${warnings.length} warnings`;
    for (const text of warnings) {
      const item = document.createElement("li");
      item.textContent = text;
      $("warnings").querySelector("ul").append(item);
    }
  }
  const option = (select, value, text) => {
    const item = document.createElement("option");
    item.value = value;
    item.textContent = text;
    select.append(item);
    return item;
  };

  // what runs along the slider and the charts: time, a load factor that grows, or the number of the state
  const grows = timed || (viscorod.increasing(instants) && viscorod.increasing(samples));
  const x = Array.from(grows ? instants : arrays.numbers.values);
  const chartX = Array.from(grows ? samples : arrays.sample_numbers.values);
  const xLabel = timed ? `time [${second}]` : grows ? "load factor" : "state";
  const span = x[x.length - 1] - x[0];

  let space = null;
  try {
    space = new viscorod.Space(meta, arrays, $("space"));
  } catch (error) {
    $("failure").hidden = false;
    $("failure").textContent = `The view in space needs WebGL, which this browser does not give (${error.message}). The charts work without it.`;
  }

  let mode = null; // the one that swings, of a page of modes
  const charts = [];
  let along = null;
  const total = x.length;
  const show = (at, k, part) => {
    if (space) space.show(k, part);
    if (along) along.now();
    for (const chart of charts) chart.point(at);
    $("scrub").value = at;
    const nearest = part < 0.5 ? k : k + 1;
    const instant = instants[k] + part * (instants[Math.min(k + 1, total - 1)] - instants[k]);
    if (mode) {
      $("now").textContent = `phase ${Math.round((360 * (at - x[mode.first])) / (x[mode.last] - x[mode.first]))}\u00b0`;
      $("scrub").setAttribute("aria-valuetext", $("now").textContent);
      return;
    }
    $("now").textContent = `${timed ? "t = " : "load factor "}${instant.toFixed(digits).replace("-", "\u2212")}${timed ? ` ${second}` : ""}, frame ${nearest + 1}/${total}`;
    $("scrub").setAttribute("aria-valuetext", $("now").textContent);
  };
  // as many digits as tell neighbouring frames apart
  const [least, most] = instants.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  const digits = most > least ? Math.max(timed ? 0 : 3, Math.min(9, Math.ceil(-Math.log10((most - least) / total)))) : 3;
  const player = new viscorod.Player(x, 1, show);
  const goTo = (at) => player.goTo(at);

  // charts
  const xRange = () => (span > 0 ? [x[0], x[x.length - 1]] : [x[0] - 0.5, x[0] + 0.5]);
  const common = { xLabel, xRange, goTo };
  const replace = (number, make) => {
    if (charts[number]) charts[number].remove();
    charts[number] = make();
    charts[number].point(player.at);
  };
  if (!meta.modes.length) meta.histories.forEach((group, k) => option($("history"), k, `${group.label} [${group.unit}]`));
  const drawHistory = () => {
    const group = meta.histories[Number($("history").value)];
    replace(0, () => viscorod.historyChart($("history-chart"), group, chartX, arrays[group.array], common, meta.main));
  };
  if (meta.modes.length) {
    for (const chart of document.querySelectorAll(".chart")) chart.hidden = true;
  } else {
    $("history").addEventListener("change", drawHistory);
    drawHistory();
  }
  if (!meta.modes.length) replace(1, () => viscorod.energyChart($("energy-chart"), meta.energy, chartX, arrays.energy, common));
  if (!meta.modes.length && meta.energy.fraction !== undefined) {
    const fraction = 100 * meta.energy.fraction;
    const remainder = `numerical remainder at most ${viscorod.text(fraction, 2)} % of the ${viscorod.text(meta.energy.moved)} ${meta.energy.unit} that moved`;
    $("energy-title").textContent = `Energy account; ${meta.energy.moved > 0 ? remainder : "nothing moved"}`;
  } else $("energy-title").textContent = "Elastic energy";
  if (meta.decay) {
    meta.decay.time = Array.from(told(meta.decay.time));
    meta.decay.period = Array.from(told(meta.decay.period));
    $("decay").hidden = false;
    $("decay-title").textContent = `Damping ratio of every cycle of ${meta.decay.place} along ${meta.decay.axis}; ${meta.decay.limit_name}: ${viscorod.text(meta.decay.limit)}`;
    replace(2, () => viscorod.decayChart($("decay-chart"), meta.decay, common));
    viscorod.decayTable($("cycles"), meta.decay, second);
  }

  // player
  $("scrub").min = x[0];
  $("scrub").max = x[x.length - 1];
  $("scrub").addEventListener("input", () => goTo(Number($("scrub").value)));
  const press = (on) => {
    player.play(on);
    $("play").textContent = player.playing ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(player.playing));
  };
  player.ended = () => press(false);
  $("play").disabled = x.length < 2;
  $("play").addEventListener("click", () => press(!player.playing));
  const { options, chosen } = viscorod.speeds(span / clock || 1, timed);
  for (const speed of options) option($("speed"), speed, timed ? (speed === 1 ? "real time" : `${speed} \u00d7 real time`) : `${speed} \u00d7`).selected = speed === chosen;
  const pace = timed ? clock : meta.modes.length ? (x[meta.modes[0].last] - x[0]) / 2 : span / 8; // a swing in two seconds
  const setSpeed = () => { player.rate = Number($("speed").value) * pace; };
  $("speed").addEventListener("change", setSpeed);
  setSpeed();
  $("loop").addEventListener("change", () => { player.repeat = $("loop").checked; });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const on = event.target.tagName;
    const slider = event.target === $("scrub");
    if (on === "SELECT" || on === "SUMMARY" || (on === "INPUT" && !slider)) return;
    const actions = {
      " ": () => press(!player.playing),
      ArrowLeft: () => { press(false); player.step(-1); },
      ArrowRight: () => { press(false); player.step(1); },
      Home: () => goTo(x[0]),
      End: () => goTo(x[x.length - 1]),
      f: () => space && space.fit(),
      F: () => $("full").click(),
      s: () => $("save").click(),
      d: () => $("dark").click(),
    };
    if (!(event.key in actions) || (on === "BUTTON" && event.key === " ")) return;
    event.preventDefault();
    actions[event.key]();
  });

  $("full").addEventListener("click", () => (document.fullscreenElement ? document.exitFullscreen() : $("left").requestFullscreen()));
  $("save").disabled = !space;
  $("save").addEventListener("click", () => space && space.picture(`${meta.title ? `${meta.title}, ` : ""}${$("now").textContent}`).then((blob) => viscorod.hand(blob, "viscorod.png")));
  viscorod.theme($("dark"), () => {
    if (space) space.dress();
    for (const chart of [...charts, along]) if (chart) chart.dress();
  });
  if (space) viscorod.connect(space, meta, arrays, option, $);
  if (space && meta.lines.length && !meta.modes.length) {
    meta.lines.forEach(({ rod }, k) => option($("along-rod"), k, rod));
    $("along-rod").hidden = meta.lines.length < 2;
    const draw = () => {
      if (along) along.remove();
      along = null;
      $("along").hidden = !space.field;
      if (!space.field) return;
      const number = Number($("along-rod").value);
      const [from, to, s] = space.reader.along(space.field, number);
      const [scale, unit] = meta.length;
      $("along-title").textContent = `${space.field.title[0].toUpperCase()}${space.field.title.slice(1)} along ${meta.lines.length < 2 ? meta.lines[0].rod : "the rod"} now`;
      along = viscorod.alongChart($("along-chart"), space.field, s.map((v) => scale * v), space.reader.range(space.field), unit, meta.lines[number].rod);
      along.now = () => along.plot.setData([along.plot.data[0], Array.from(space.reader.at(space.field, ...space.frame)).slice(from, to)], false);
      along.now();
    };
    for (const id of ["field", "along-rod"]) $(id).addEventListener("change", draw);
    draw();
  }
  if (meta.modes.length) {
    const choose = (k) => {
      mode = meta.modes[k];
      player.within(mode.first, mode.last);
      [$("scrub").min, $("scrub").max] = [x[mode.first], x[mode.last]];
      for (const [j, row] of [...$("modes").tBodies[0].rows].entries()) row.setAttribute("aria-selected", String(j === k));
      $("mode").value = k;
      if (space) space.leaveTrace($("trace").value === "" ? null : Number($("trace").value));
      goTo(x[mode.first]);
    };
    $("mode-title").textContent = meta.film.title;
    viscorod.modeTable($("modes"), meta.film.head, meta.modes, choose);
    meta.modes.forEach(({ name }, k) => option($("mode"), k, `${k + 1}: ${name}`));
    $("mode").addEventListener("change", () => choose(Number($("mode").value)));
    for (const id of ["mode-choice", "mode-list"]) $(id).hidden = false;
    for (const id of ["bar", "keys"]) $(id).hidden = true;
    for (const id of ["trace", "show-loads", "loop"]) $(id).parentElement.hidden = true;
    $("now").style.minWidth = "10ch";
    $("player").append($("more")); // alone it needs no row of its own
    $("shown").hidden = true;
    $("trace").value = "";
    $("trace").dispatchEvent(new Event("change"));
    choose(meta.film.start);
    if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) press(true);
  } else goTo(x[0]);
  document.documentElement.dataset.ready = "yes";
};

/* Names and numbers of what swings; a row that is clicked does. */
viscorod.modeTable = function (table, head, modes, choose) {
  for (const text of head) table.tHead.rows[0].appendChild(document.createElement("th")).textContent = text;
  const body = table.createTBody();
  modes.forEach(({ name, cells }, k) => {
    const row = body.insertRow();
    const texts = cells.map((cell, j) => (typeof cell === "string" ? cell : viscorod.text(cell, j ? 4 : 6)));
    for (const text of [`${k + 1}`, name, ...texts]) row.insertCell().textContent = text;
    row.tabIndex = 0;
    row.addEventListener("click", () => choose(k));
    row.addEventListener("keydown", (event) => { if (event.key === "Enter") choose(k); });
  });
};

/* The controls of the view in space. */
viscorod.connect = function (space, meta, arrays, option, $) {
  const fields = viscorod.fields(meta, arrays);
  option($("field"), "", "none");
  for (const field of fields) option($("field"), field.key, `${field.title}${field.unit === "1" ? "" : ` [${field.unit}]`}`);
  const context = $("ramp").getContext("2d");
  space.onRange = (low, high, signed) => {
    const unit = !space.field || space.field.unit === "1" ? "" : ` ${space.field.unit}`;
    $("scale-low").textContent = `${viscorod.text(low, 3)}${unit}`;
    $("scale-high").textContent = `${viscorod.text(high, 3)}${unit}`;
    const table = meta.colours[signed ? "signed" : "plain"];
    for (let k = 0; k < 256; k++) {
      context.fillStyle = `rgb(${table[Math.floor((k * table.length) / 256)].join(",")})`;
      context.fillRect(k, 0, 1, 1);
    }
  };
  const again = () => space.show(...space.frame);
  $("field").addEventListener("change", () => {
    space.field = fields.find((field) => field.key === $("field").value) || null;
    $("scale").style.visibility = space.field ? "visible" : "hidden";
    again();
  });
  $("range").addEventListener("change", () => { space.rangeNow = $("range").value === "now"; again(); });
  const first = fields.find((field) => ["fibre", "bending"].includes(field.key)) || fields[0];
  $("field").value = first ? first.key : "";
  $("field").dispatchEvent(new Event("change"));

  option($("trace"), "", "nothing");
  meta.scene.places.forEach(({ label, mark }, k) => { option($("trace"), mark, label).selected = k === 0; });
  const trace = () => space.leaveTrace($("trace").value === "" ? null : Number($("trace").value));
  $("trace").addEventListener("change", () => { trace(); again(); });
  trace();

  // rods thinner than a line are drawn thicker unless their true size is asked for
  const widest = meta.lines.some((line) => line.known) ? Math.max(...arrays.halves.values) : 0;
  const legible = widest > 0 ? Math.max(1, (0.004 * meta.look.size) / widest) : 1;
  const sizes = [["legible", legible > 1 ? "enlarged to be seen" : widest > 0 ? "true size" : "thin tubes", legible]];
  if (legible > 1) sizes.push(["true", "true size", 1]);
  for (const factor of [2, 5, 10]) if (factor > legible) sizes.push([String(factor), `${factor} \u00d7`, factor]);
  for (const [value, text] of sizes) option($("thickness"), value, text);
  const unknown = meta.lines.filter((line) => !line.known).length;
  const thicken = () => {
    const [, , factor] = sizes.find(([value]) => value === $("thickness").value);
    space.surface.factor = factor;
    const notes = [];
    if (factor !== 1 && widest > 0) notes.push(`Sections are drawn ${viscorod.text(factor, 3)} times as large as they are.`);
    if (unknown) notes.push("Rods whose section has no known outline are drawn as round tubes.");
    $("section-note").textContent = notes.join(" ");
    again();
  };
  $("thickness").addEventListener("change", thicken);
  thicken();

  const shows = { reference: [space.reference], symbols: [space.symbols.parts], loads: [space.symbols.loads], grid: [space.grid] };
  for (const [word, objects] of Object.entries(shows)) {
    $(`show-${word}`).addEventListener("change", () => {
      for (const object of objects) object.visible = $(`show-${word}`).checked;
      space.refresh();
    });
  }
  $("show-names").addEventListener("change", () => { space.showNames = $("show-names").checked; space.refresh(); });
  for (const button of document.querySelectorAll("[data-look]")) button.addEventListener("click", () => space.look(button.dataset.look));
  const { cell } = meta.look;
  $("grid-size").textContent = `grid ${cell >= 0.01 && cell < 1000 ? `${viscorod.text(cell, 3)} m` : viscorod.prefixed(cell, "m")}`;
  $("show-grid").addEventListener("change", () => { $("grid-size").hidden = !$("show-grid").checked; });
  const legend = [...space.symbols.kinds.values(), ["reference shape", viscorod.COLOUR.reference]];
  for (const [k, { name }] of meta.ghosts.entries()) legend.push([name, viscorod.GHOSTS[k % 3]]);
  if (!meta.modes.length) legend.push(["trace", viscorod.COLOUR.trace]);
  for (const [text, colour] of legend) {
    const entry = document.createElement("span");
    const patch = document.createElement("i");
    patch.style.background = `var(${colour})`;
    entry.append(patch, text);
    $("legend").append(entry);
  }
};

viscorod.start().catch((error) => {
  const box = document.getElementById("failure");
  box.hidden = false;
  box.textContent = `The page could not be shown: ${error.message}`;
  console.error(error);
});
