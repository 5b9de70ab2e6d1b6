"use strict";
/* A chart of curves that may turn back: lines, points, marks, and the chosen place on each. Drawn as SVG. */

viscorod.COLOURS = Array.from({ length: 8 }, (_, k) => `var(--many-${k})`);

viscorod.markColour = (kind) => (kind.startsWith("limit") ? "var(--needle)" : "var(--ink)");

/* About `count` round numbers between two; powers of ten, with 2 and 5 where these are few, on a logarithmic axis. */
viscorod.ticks = function (low, high, count, log) {
  if (log) {
    const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
    const every = Math.max(1, Math.ceil((last - first) / count));
    const parts = last - first <= 2 ? [1, 2, 5] : [1];
    const found = [];
    for (let p = first; p <= last; p += every) for (const d of parts) found.push(d * 10 ** p);
    return found.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
  }
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((d) => d * power).find((d) => d >= raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(12)));
  return found;
};

viscorod.CurveChart = class {
  /* `row` returns a row of an array, [name, number], at the chosen place; `choose` is told a place that was clicked. */
  constructor(host, chart, row, choose) {
    Object.assign(this, { chart, row, choose, at: 0, brought: null });
    this.place = document.createElement("div");
    this.place.className = "curve-chart";
    const title = document.createElement("h2");
    title.textContent = chart.title;
    this.svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    this.svg.setAttribute("role", "img");
    this.svg.setAttribute("aria-label", `${chart.title}: ${chart.y} over ${chart.x}`);
    this.told = document.createElement("div");
    this.told.className = "told";
    this.place.append(title, this.svg, this.told);
    this.names();
    host.append(this.place);
    this.svg.addEventListener("pointermove", (event) => this.tell(this.nearest(event)));
    this.svg.addEventListener("pointerleave", () => this.tell(null));
    this.svg.addEventListener("pointerdown", (event) => {
      const found = this.nearest(event);
      if (found && this.chart.follows) this.choose(found.place);
    });
    new ResizeObserver(() => this.draw()).observe(this.place);
  }

  get hidden() { return this.place.hidden; }
  set hidden(value) { this.place.hidden = value; if (!value) this.draw(); }

  names() {
    const list = document.createElement("div");
    list.className = "names";
    this.place.append(list);
    for (const kind of new Set(this.chart.marks.map((mark) => mark.kind))) {
      const ring = document.createElement("b");
      ring.style.borderColor = viscorod.markColour(kind);
      list.appendChild(document.createElement("span")).append(ring, kind);
    }
    if (this.chart.curves.length < 2) return;
    const buttons = list.appendChild(document.createElement("span"));
    this.chart.curves.forEach(({ name, colour }, k) => {
      const button = document.createElement("button");
      button.type = "button";
      button.setAttribute("aria-pressed", "false");
      const patch = document.createElement("i");
      patch.style.borderColor = viscorod.COLOURS[colour % viscorod.COLOURS.length];
      button.append(patch, name);
      button.addEventListener("click", () => {
        this.brought = this.brought === k ? null : k;
        [...buttons.children].forEach((other, j) => other.setAttribute("aria-pressed", String(this.brought === j)));
        this.draw();
      });
      buttons.append(button);
    });
  }

  /* Ends of an axis: those that are given, or of all that is drawn. */
  ends(side) {
    const { chart } = this;
    const log = (chart.log || []).includes(side);
    let given = side === "y" || chart.equal ? chart.range : null;
    if (given) return given;
    let [low, high] = [Infinity, -Infinity];
    const take = (v) => { if (Number.isFinite(v) && (!log || v > 0)) { if (v < low) low = v; if (v > high) high = v; } };
    for (const curve of chart.curves) this.row(curve[side], this.at).forEach(take);
    for (const mark of chart.marks) take(mark[side]);
    if (!(low <= high)) return log ? [0.1, 1] : [0, 1];
    if (log) return low === high ? [low / 2, high * 2] : [low / 1.25, high * 1.25];
    const margin = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
    return side === "x" && !chart.equal && !chart.side ? (low === high ? [low - margin, high + margin] : [low, high]) : [low - margin, high + margin];
  }

  draw() {
    const width = this.place.clientWidth;
    if (this.hidden || width < 50) return;
    const { chart, svg } = this;
    const height = chart.equal ? Math.min(width, 380) : chart.side ? 220 : 320;
    const box = (this.box = { left: 66, right: width - 12, top: 8, bottom: height - 40 });
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const logs = { x: (chart.log || []).includes("x"), y: (chart.log || []).includes("y") };
    let [x, y] = [this.ends("x"), this.ends("y")];
    if (chart.equal) [x, y] = this.alike(x, y, box);
    const scale = (ends, first, last, log) => {
      const f = log ? Math.log10 : (v) => v;
      return (v) => first + ((f(v) - f(ends[0])) / (f(ends[1]) - f(ends[0]))) * (last - first);
    };
    this.sx = scale(x, box.left, box.right, logs.x);
    this.sy = scale(y, box.bottom, box.top, logs.y);
    svg.replaceChildren();
    this.axes(x, y, logs, box, height);
    this.clip = `clip${(viscorod.clips = (viscorod.clips || 0) + 1)}`;
    const inside = this.add(svg, "clipPath", { id: this.clip });
    this.add(inside, "rect", { x: box.left - 5, y: box.top - 5, width: box.right - box.left + 10, height: box.bottom - box.top + 10 });
    this.inner = this.add(svg, "g", { "clip-path": `url(#${this.clip})` });
    for (const guide of chart.guides) this.guide(guide, x, y);
    chart.curves.forEach((curve, k) => this.curve(curve, this.brought === null || this.brought === k));
    for (const mark of chart.marks) {
      const dot = this.add(this.inner, "circle", { cx: this.sx(mark.x), cy: this.sy(mark.y), r: 5, fill: "var(--page)", stroke: viscorod.markColour(mark.kind), "stroke-width": 1.8, class: "mark" });
      this.add(dot, "title", {}).textContent = mark.text;
    }
    this.over = this.add(this.inner, "g", {});
    this.show(this.at, false);
  }

  alike(x, y, box) {
    const [w, h] = [box.right - box.left, box.bottom - box.top];
    const unit = Math.max((x[1] - x[0]) / w, (y[1] - y[0]) / h);
    const grown = (ends, size) => { const m = 0.5 * (ends[0] + ends[1]); return [m - 0.5 * unit * size, m + 0.5 * unit * size]; };
    return [grown(x, w), grown(y, h)];
  }

  add(parent, kind, attributes) {
    const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    parent.append(element);
    return element;
  }

  axes(x, y, logs, box, height) {
    const { chart, svg } = this;
    const write = (text, attributes) => { this.add(svg, "text", attributes).textContent = text; };
    for (const v of viscorod.ticks(x[0], x[1], Math.max(2, Math.floor((box.right - box.left) / 70)), logs.x)) {
      const px = this.sx(v);
      this.add(svg, "line", { x1: px, x2: px, y1: box.top, y2: box.bottom, stroke: "var(--faint)" });
      write(viscorod.text(v, 6), { x: px, y: box.bottom + 15, "text-anchor": "middle" });
    }
    for (const v of viscorod.ticks(y[0], y[1], Math.max(2, Math.floor((box.bottom - box.top) / 32)), logs.y)) {
      const py = this.sy(v);
      this.add(svg, "line", { x1: box.left, x2: box.right, y1: py, y2: py, stroke: v === 0 ? "var(--edge)" : "var(--faint)" });
      write(viscorod.text(v, 6), { x: box.left - 5, y: py + 4, "text-anchor": "end" });
    }
    this.add(svg, "rect", { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top, fill: "none", stroke: "var(--edge)" });
    write(chart.x, { x: 0.5 * (box.left + box.right), y: height - 6, "text-anchor": "middle" });
    write(chart.y, { transform: `translate(13 ${0.5 * (box.top + box.bottom)}) rotate(-90)`, "text-anchor": "middle" });
  }

  guide(guide, x, y) {
    const line = guide.x.map((v, k) => `${this.sx(v).toFixed(2)},${this.sy(guide.y[k]).toFixed(2)}`).join(" ");
    this.add(this.inner, "polyline", { points: line, fill: "none", stroke: "var(--edge)", "stroke-width": 1, "stroke-dasharray": "6 3" });
    if (!guide.text) return;
    const last = guide.x.length - 1;
    const part = Math.min(1, (y[1] - guide.y[0]) / (guide.y[last] - guide.y[0] || 1), (x[1] - guide.x[0]) / (guide.x[last] - guide.x[0] || 1)) * 0.97;
    const [px, py] = [guide.x[0] + part * (guide.x[last] - guide.x[0]), guide.y[0] + part * (guide.y[last] - guide.y[0])];
    const label = this.add(this.inner, "text", { x: this.sx(px) - 4, y: this.sy(py) - 3, "text-anchor": "end" });
    label.style.fill = "var(--soft)";
    label.textContent = guide.text;
  }

  /* A curve, in pieces that are dashed or not. */
  curve(curve, clear) {
    const [x, y] = [this.row(curve.x, this.at), this.row(curve.y, this.at)];
    const stroke = viscorod.COLOURS[curve.colour % viscorod.COLOURS.length];
    const opacity = clear ? 1 : 0.18;
    const point = (k) => `${this.sx(x[k]).toFixed(2)},${this.sy(y[k]).toFixed(2)}`;
    if (curve.points || x.length === 1) {
      for (let k = 0; k < x.length; k++) this.add(this.inner, "circle", { cx: this.sx(x[k]), cy: this.sy(y[k]), r: 4, fill: stroke, opacity });
      return;
    }
    const dashed = curve.dashed ? this.row(curve.dashed, this.at) : null;
    const whole = this.chart.turn || Infinity;
    const jumps = (k) => k < x.length && Math.abs(y[k] - y[k - 1]) > 0.5 * whole; // an angle passes half a turn
    let piece = [point(0)];
    for (let k = 1; k < x.length; k++) {
      if (jumps(k)) { piece = [point(k)]; continue; }
      piece.push(point(k));
      const kind = dashed !== null && (dashed[k - 1] !== 0 || dashed[k] !== 0);
      const next = k + 1 < x.length && dashed !== null && (dashed[k] !== 0 || dashed[k + 1] !== 0);
      if (k + 1 === x.length || kind !== next || jumps(k + 1)) {
        const look = { points: piece.join(" "), fill: "none", stroke, opacity, "stroke-width": clear && this.brought !== null ? 2.6 : 1.7 };
        if (kind) look["stroke-dasharray"] = "5 4";
        this.add(this.inner, "polyline", look);
        piece = [point(k)];
      }
    }
  }

  /* The place on a curve that is nearest to the pointer. */
  nearest(event) {
    if (!this.sx) return null;
    const frame = this.svg.getBoundingClientRect();
    const [px, py] = [event.clientX - frame.left, event.clientY - frame.top];
    let best = null;
    this.chart.curves.forEach((curve, number) => {
      const [x, y] = [this.row(curve.x, this.at), this.row(curve.y, this.at)];
      for (let k = 0; k < x.length; k++) {
        const apart = (this.sx(x[k]) - px) ** 2 + (this.sy(y[k]) - py) ** 2;
        if (!best || apart < best.apart) best = { apart, place: k, number, x: x[k], y: y[k], name: curve.name };
      }
    });
    for (const mark of this.chart.marks) {
      const apart = (this.sx(mark.x) - px) ** 2 + (this.sy(mark.y) - py) ** 2;
      if (apart < 64) return { ...best, x: mark.x, y: mark.y, name: mark.text };
    }
    return best;
  }

  tell(found) {
    this.told.textContent = found ? `${found.name}: ${viscorod.text(found.x, 6)}, ${viscorod.text(found.y, 6)}` : "";
  }

  /* Mark the chosen place; charts whose curves belong to it are drawn anew. */
  show(at, again = true) {
    this.at = at;
    if (this.hidden || !this.sx) return;
    if (again && this.chart.curves.some(({ x, y }) => x[1] < 0 || y[1] < 0)) { this.draw(); return; }
    this.over.replaceChildren();
    if (!this.chart.follows) return;
    for (const curve of this.chart.curves) {
      const [x, y] = [this.row(curve.x, at), this.row(curve.y, at)];
      this.add(this.over, "circle", { cx: this.sx(x[at]), cy: this.sy(y[at]), r: 4.5, fill: "var(--needle)", stroke: "var(--page)", "stroke-width": 1, class: "chosen" });
    }
  }
};
