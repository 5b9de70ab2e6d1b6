"use strict";
/* The page of curves: charts, the place that is chosen along them, tables. */

viscorod.table = function (place, title, head, rows) {
  if (title) place.createCaption().textContent = title;
  const line = place.createTHead().insertRow();
  for (const text of head) {
    const cell = document.createElement("th");
    cell.textContent = text;
    line.append(cell);
  }
  const body = place.createTBody();
  for (const cells of rows) {
    const row = body.insertRow();
    for (const cell of cells) row.insertCell().textContent = typeof cell === "number" ? viscorod.text(cell, 6) : cell;
    row.cells[0].style.whiteSpace = row.cells[0].textContent.length > 12 ? "" : "nowrap"; // names such as bend_1 1
  }
  return body;
};

viscorod.start = async function () {
  const $ = (id) => document.getElementById(id);
  const { meta, arrays } = await viscorod.read();
  const row = ([name, number], at) => {
    const { shape, values } = arrays[name];
    const k = number < 0 ? at : number;
    return values.subarray(k * shape[1], (k + 1) * shape[1]);
  };
  $("title").textContent = meta.title || meta.heading;
  $("heading").textContent = meta.heading;
  $("notes").textContent = [...meta.notes, meta.version ? `viscorod ${meta.version}` : "viscorod"].join(" \u00b7 ");
  const warnings = [...(meta.outcome === "completed" ? [] : [`outcome: ${meta.outcome}`]), ...meta.warnings];
  $("warnings").hidden = !warnings.length;
  $("warnings").querySelector("summary").textContent = warnings.length === 1 ? "1 warning" : `${warnings.length} warnings`;
  for (const text of warnings) $("warnings").querySelector("ul").appendChild(document.createElement("li")).textContent = text;

  const places = row([meta.slider.places, 0], 0);
  const unit = meta.slider.unit ? ` ${meta.slider.unit}` : "";
  let at = 0;
  let charts = [];
  const live = viscorod.table($("live"), "", meta.live.head, meta.live.rows.map((cells) => cells.map((cell) => (typeof cell === "string" ? cell : ""))));
  const show = (place) => {
    at = Math.min(Math.max(place, 0), places.length - 1);
    $("scrub").value = at;
    $("now").textContent = `${viscorod.text(places[at], 6)}${unit}, ${at + 1}/${places.length}`;
    $("scrub").setAttribute("aria-valuetext", $("now").textContent);
    for (const chart of charts) chart.show(at);
    meta.live.rows.forEach((cells, j) => cells.forEach((cell, k) => {
      if (typeof cell !== "string") live.rows[j].cells[k].textContent = viscorod.text(row(cell, at)[at], 6);
    }));
  };
  const chosen = meta.choices.map(() => 0);
  const select = () => {
    for (const chart of charts) chart.hidden = Object.entries(chart.chart.when).some(([number, value]) => chosen[number] !== value);
    show(at);
  };
  meta.choices.forEach(({ label, names }, number) => {
    if (names.length < 2) return;
    const box = document.createElement("label");
    const list = document.createElement("select");
    names.forEach((name, k) => { const item = document.createElement("option"); item.value = k; item.textContent = name; list.append(item); });
    list.addEventListener("change", () => { chosen[number] = Number(list.value); select(); });
    box.append(`${label} `, list);
    $("choices").append(box);
  });
  $("where").textContent = meta.slider.label;
  $("scrub").max = places.length - 1;
  $("scrub").addEventListener("input", () => show(Number($("scrub").value)));
  charts = meta.charts.map((chart) => new viscorod.CurveChart(chart.side ? $("side") : $("curves"), chart, row, show));
  if (meta.charts.some(({ side }) => side)) $("curves").append($("live"), $("tables")); // else the other column is too long
  for (const { title, head, rows } of meta.tables) {
    const table = $("tables").appendChild(document.createElement("table"));
    table.className = "numbers";
    viscorod.table(table, title, head, rows);
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || ["SELECT", "INPUT", "BUTTON"].includes(event.target.tagName)) return;
    const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: places.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    show(to);
  });
  select();
  viscorod.theme($("dark"), () => {});
  document.documentElement.dataset.ready = "yes";
};

viscorod.start().catch((error) => {
  const box = document.getElementById("failure");
  box.hidden = false;
  box.textContent = `The page could not be shown: ${error.message}`;
  console.error(error);
});
