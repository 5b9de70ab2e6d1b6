"use strict";
/* Charts beside the view: each has a line at the present instant, and a click goes to another. */

viscorod.Chart = class {
  constructor(place, options, data, goTo) {
    this.place = place;
    this.height = options.height;
    this.strokes = options.series.map(({ stroke }) => stroke);
    const ink = () => viscorod.style("--ink");
    const thin = (name) => ({ stroke: () => viscorod.style(name), width: 1 });
    const axis = { stroke: ink, grid: thin("--faint"), ticks: thin("--edge"), font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    const values = (_, splits) => splits.map((value) => (value === null ? "" : viscorod.text(Number(value.toPrecision(8)), 6)));
    this.plot = new uPlot(
      {
        width: Math.max(place.clientWidth, 200),
        height: options.height,
        pxAlign: 0, // lines where they are, not on whole pixels
        scales: { x: { time: false, range: options.xRange }, y: options.yRange ? { range: options.yRange } : {} },
        axes: [
          { ...axis, label: options.xLabel, labelSize: 18, size: 34, space: 55, values },
          { ...axis, label: options.yLabel, labelSize: 18, size: 58, space: 22, values },
        ],
        series: [{ label: options.xLabel, value: (_, v) => (v === null ? "" : viscorod.text(v)) }, ...options.series],
        bands: options.bands,
        cursor: { drag: { x: false, y: false }, y: false, points: { show: false } },
        legend: { live: true, show: !options.still },
        hooks: { ready: [() => { this.told = 0; this.point(this.x); }] }, // the chart empties its legend as it starts
      },
      data,
      place,
    );
    this.needle = document.createElement("div");
    this.needle.className = "needle";
    Object.assign(this.needle.style, { position: "absolute", top: "0", bottom: "0", width: "2px", background: "var(--needle)", pointerEvents: "none", left: "-1px" });
    if (options.still) this.point = () => {}; // nothing along it is now
    else this.plot.over.append(this.needle);
    let held = false;
    const go = (event) => goTo(this.plot.posToVal(event.clientX - this.plot.over.getBoundingClientRect().left, "x"));
    this.plot.over.addEventListener("pointerdown", (event) => { held = true; go(event); });
    this.plot.over.addEventListener("pointermove", (event) => { if (held) go(event); });
    window.addEventListener("pointerup", () => { held = false; });
    new ResizeObserver(() => {
      const width = Math.max(place.clientWidth, 200);
      if (Math.abs(width - this.plot.width) > 1) this.plot.setSize({ width, height: this.height });
      this.point(this.x);
    }).observe(place);
  }

  /* Move the line, and the numbers under the chart unless the pointer reads them. */
  point(x) {
    if (x === undefined || this.place.hidden) return;
    this.x = x;
    this.needle.style.transform = `translateX(${this.plot.valToPos(x, "x")}px)`;
    const now = performance.now();
    if (this.plot.cursor.left >= 0 || (this.told && now - this.told < 100)) return;
    this.told = now;
    this.plot.setLegend({ idx: this.plot.valToIdx(x) }, false);
  }

  /* Take the colours of the page, which became light or dark. */
  dress() {
    this.plot.redraw(false);
    const rows = [...this.place.querySelectorAll(".u-series .u-marker")].slice(-this.strokes.length);
    rows.forEach((mark, k) => { if (typeof this.strokes[k] === "function") mark.style.borderColor = this.strokes[k](); });
  }

  remove() {
    this.plot.destroy();
    this.place.replaceChildren();
  }
};

viscorod.DASHES = [[7, 4], [2, 3], [9, 3, 2, 3]];
viscorod.PALETTE = [0, 1, 2].map((k) => () => viscorod.style(`--curve-${k}`));

/* What writes values of curves: one below the rounding of the largest of them all is 0. */
viscorod.toldOf = function (curves) {
  let size = 0;
  for (const curve of curves) for (const v of curve) if (Math.abs(v) > size) size = Math.abs(v);
  return (v) => (v === null || v === undefined ? "" : viscorod.text(Math.abs(v) < 1e-12 * size ? 0 : v));
};

viscorod.historyChart = function (place, group, x, array, common, main) {
  const count = x.length;
  const curves = group.curves.map((_, k) => array.values.subarray(k * count, (k + 1) * count));
  const told = viscorod.toldOf([array.values]);
  const value = (_, v) => told(v);
  const series = group.curves.map((name, k) => ({ label: name, stroke: viscorod.PALETTE[k % 3], width: group.curves.length > 1 && group.place && k !== main ? 1.2 : 2, value, points: { show: count < 3 } }));
  // those of other results, dashed; gaps where they have nothing
  for (const [k, other] of (group.others || []).entries()) {
    const own = array.values.subarray((group.curves.length + k) * count, (group.curves.length + k + 1) * count);
    curves.push(Array.from(own, (v) => (Number.isNaN(v) ? null : v)));
    series.push({ label: other.name, stroke: viscorod.PALETTE[other.curve % 3], width: 1.6, dash: viscorod.DASHES[other.result % 3], value, points: { show: false } });
  }
  return new viscorod.Chart(place, { ...common, height: 250, yLabel: group.unit, series }, [x, ...curves], common.goTo);
};

/* A field along one rod at the present instant, in the range of all instants. */
viscorod.alongChart = function (place, field, s, range, sLabel, rod) {
  const [low, high] = range;
  const margin = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1;
  const value = (_, v) => (v === null || v === undefined ? "" : viscorod.text(v));
  const unit = field.unit === "1" ? "" : ` [${field.unit}]`;
  const series = [{ label: `${field.title}${unit}`, stroke: viscorod.PALETTE[0], width: 2, value, points: { show: s.length < 3 } }];
  const options = { height: 200, xLabel: `arc length of ${rod} [${sLabel}]`, yLabel: field.unit === "1" ? "" : field.unit, series };
  const chart = new viscorod.Chart(place, { ...options, xRange: () => [s[0], s[s.length - 1]], yRange: () => [low - margin, high + margin], still: true }, [s, s.map(() => 0)], () => {});
  return chart;
};

/* Where the energy is, stacked; a line shows what was there and came in. The gap between them is numerical. */
viscorod.energyChart = function (place, energy, x, array, common) {
  const count = x.length;
  const rows = Array.from({ length: array.shape[0] }, (_, k) => array.values.subarray(k * count, (k + 1) * count));
  const layers = energy.stacked.length;
  const sums = [];
  for (let k = 0; k < layers; k++) sums.push(k ? rows[k].map((value, j) => value + sums[k - 1][j]) : rows[0]);
  const areas = layers === 1 ? [1] : [3, 2, 1, 0].slice(-layers);
  const fills = areas.map((k) => () => viscorod.style(`--area-${k}`));
  const told = viscorod.toldOf(rows);
  const own = (row) => (_, v, __, index) => (v === null || index === null || index === undefined ? "" : told(row[index]));
  // the highest first, so that lower ones are drawn over it
  const order = [...Array(layers).keys()].reverse();
  const series = order.map((k) => ({ label: energy.stacked[k], stroke: fills[k], fill: fills[k], width: 0.5, value: own(rows[k]), points: { show: count < 3 } }));
  const data = [x, ...order.map((k) => sums[k])];
  if (energy.line) {
    series.push({ label: energy.line, stroke: () => viscorod.style("--ink"), width: 1.6, value: own(rows[layers]), points: { show: false } });
    data.push(rows[layers]);
    series.push({ label: "numerical remainder", stroke: () => viscorod.style("--remainder"), width: 1.2, dash: [4, 3], value: own(rows[layers + 1]), points: { show: false } });
    data.push(rows[layers + 1]);
  }
  return new viscorod.Chart(place, { ...common, height: 250, yLabel: energy.unit, series }, data, common.goTo);
};

viscorod.decayChart = function (place, decay, common) {
  const x = decay.ratio.map((_, k) => 0.5 * (decay.time[k] + decay.time[k + 1]));
  const most = Math.max(decay.limit, ...decay.ratio);
  const least = Math.min(0, ...decay.ratio);
  const value = (_, v) => (v === null || v === undefined ? "" : viscorod.text(v));
  const name = decay.limit_name;
  const series = [
    { label: "damping ratio of the cycle", stroke: viscorod.PALETTE[2], width: decay.scattered ? 0 : 1.2, points: { show: true, size: 8, fill: viscorod.PALETTE[2] }, value },
    { label: name, stroke: () => viscorod.style("--bound"), width: 1.6, dash: [6, 4], points: { show: false }, value },
  ];
  const yRange = () => [1.2 * least, most > 0 ? 1.2 * most : 0.1];
  return new viscorod.Chart(place, { ...common, height: 200, yLabel: "ratio", yRange, series }, [x, decay.ratio, x.map(() => decay.limit)], common.goTo);
};

viscorod.decayTable = function (table, decay, second) {
  const row = (cells, kind) => {
    const line = document.createElement("tr");
    for (const cell of cells) {
      const box = document.createElement(kind);
      box.textContent = cell;
      line.append(box);
    }
    table.append(line);
  };
  row(["cycle", `starts at [${second}]`, `amplitude [${decay.unit}]`, `period [${second}]`, "damping ratio"], "th");
  decay.ratio.forEach((ratio, k) => row([k + 1, ...[decay.time[k], decay.amplitude[k], decay.period[k], ratio].map((v) => viscorod.text(v, 5))], "td"));
};
