// SPDX-License-Identifier: GPL-3.0-only
// The table of report.html: sorts, searches and shows by pieces what the page's data has.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const [NAME, CHUNK, STATUS, SCORE, WHY, PHASES, PICTURE, CURVE, FIGURES, BEYOND, OWN] = [...Array(11).keys()];
  const PIECE = 100;
  const table = document.getElementById("subjects");
  const [head, body] = [table.tHead, table.tBodies[0]];
  const search = document.getElementById("search"), only = document.getElementById("only");
  const more = document.getElementById("more"), save = document.getElementById("save");
  const before = new Set(data.subjects.filter(row => row[STATUS] === "excluded").map(row => row[NAME]));
  const marked = new Set(before);
  const isChanged = () => marked.size !== before.size || [...marked].some(name => !before.has(name));
  const columns = [
    { title: "exclude" },
    { title: "" },
    { title: "subject", of: row => row[NAME] },
    { title: "stands out", of: row => row[SCORE], down: true },
    { title: "why", of: row => row[WHY] },
    { title: "volumes", of: row => row[CURVE].length ? Math.min(...row[CURVE]) : null },
    { title: "phases", of: row => row[PHASES] },
    ...data.measures.map((measure, k) => (
      { title: measure.title + (measure.percent ? ", %" : ""), about: measure.means, of: row => row[FIGURES][k] ?? null, down: true })),
  ];
  let rows = data.subjects, sorted = null, down = true, shown = 0;

  const element = (tag, text, kind) => {
    const made = document.createElement(tag);
    if (text !== undefined) made.textContent = text;
    if (kind) made.className = kind;
    return made;
  };

  const curve = heights => {
    const width = 84, high = 30, name = "http://www.w3.org/2000/svg";
    const svg = document.createElementNS(name, "svg"), line = document.createElementNS(name, "polyline");
    svg.setAttribute("width", width); svg.setAttribute("height", high); svg.setAttribute("class", "curve");
    const at = heights.map((y, i) => `${(i * (width - 2) / Math.max(heights.length - 1, 1) + 1).toFixed(1)},${(high - 1 - y * (high - 2) / 99).toFixed(1)}`);
    line.setAttribute("points", at.join(" "));
    line.setAttribute("fill", "none"); line.setAttribute("stroke", "#0f766e"); line.setAttribute("stroke-width", "1.5");
    svg.append(line);
    return svg;
  };

  const drawn = row => {
    const line = element("tr", undefined, row[STATUS]);
    const tick = element("input");
    tick.type = "checkbox"; tick.checked = marked.has(row[NAME]);
    tick.onchange = () => { tick.checked ? marked.add(row[NAME]) : marked.delete(row[NAME]); save.disabled = !isChanged(); };
    const cell = (content, kind) => { const made = element("td", undefined, kind); if (content !== null) made.append(content); line.append(made); };
    cell(tick);
    const picture = element("div");
    if (row[PICTURE] >= 0) {
      picture.className = "picture";
      picture.style.backgroundPosition = `-${row[PICTURE] % data.across * data.size}px -${Math.floor(row[PICTURE] / data.across) * data.size}px`;
    }
    cell(picture);
    const link = element("a", row[NAME]);
    link.href = `reports/${row[CHUNK]}.html#${encodeURIComponent(row[NAME])}`;
    cell(link, "words");
    cell(["failed", "left out"].includes(row[STATUS]) || !row[PHASES] ? row[STATUS] : row[SCORE] >= 1e9 ? (row[WHY].includes("no valid map") ? "invalid" : row[WHY].includes("byte by byte") ? "a copy" : "unlike") : row[SCORE].toFixed(1), row[SCORE] >= data.threshold ? "out" : "");
    cell([row[STATUS] === "excluded" ? "excluded" + (row[OWN] && !row[WHY].includes(row[OWN]) ? ` (${row[OWN]})` : "") : "", row[WHY]].filter(Boolean).join("; "), "why");
    cell(row[CURVE].length ? curve(row[CURVE]) : "");
    cell(String(row[PHASES] || ""));
    data.measures.forEach((measure, k) => {
      const value = row[FIGURES][k];
      const text = value === null || value === undefined ? "" : String(Number((measure.percent ? 100 * value : value).toPrecision(3)));
      cell(text, row[BEYOND][k] > data.threshold ? "out" : "");
    });
    return line;
  };

  const piece = () => {
    body.append(...rows.slice(shown, shown + PIECE).map(drawn));
    shown = Math.min(shown + PIECE, rows.length);
    more.hidden = shown === rows.length;
    document.getElementById("count").textContent = `${shown} of ${rows.length} shown`;
  };

  const again = () => {
    const word = search.value.trim().toLowerCase();
    rows = data.subjects.filter(row => (!only.checked || row[SCORE] >= data.threshold) &&
      (!word || row[NAME].toLowerCase().includes(word) || row[WHY].toLowerCase().includes(word)));
    if (sorted) {
      const sign = down ? -1 : 1;
      const value = row => sorted.of(row);
      rows.sort((a, b) => { // what has no figure comes last
        const x = value(a), y = value(b);
        if (x === null || y === null) return (x === null) - (y === null);
        return sign * (x < y ? -1 : x > y ? 1 : 0);
      });
    }
    for (const [k, cell] of [...head.rows[0].cells].entries()) {
      cell.classList.toggle("sorted", columns[k] === sorted);
      cell.setAttribute("aria-sort", columns[k] !== sorted ? "none" : down ? "descending" : "ascending");
    }
    body.replaceChildren(); shown = 0;
    piece();
  };

  const line = element("tr");
  for (const column of columns) {
    const cell = element("th", column.title, ["subject", "why"].includes(column.title) ? "words" : "");
    if (column.about) cell.title = column.about;
    if (column.of) cell.onclick = () => { down = sorted === column ? !down : Boolean(column.down); sorted = column; again(); };
    line.append(cell);
  }
  head.append(line);
  search.oninput = again; only.onchange = again; more.onclick = piece;

  // The file holds all that are ticked, those of before as well; with their reasons.
  save.onclick = () => {
    const quoted = text => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    const lines = data.subjects.filter(row => marked.has(row[NAME]))
      .map(row => [row[NAME], "yes", quoted(row[OWN] || row[WHY])].join(","));
    const link = element("a");
    link.href = URL.createObjectURL(new Blob(["subject,exclude,why\n" + lines.join("\n") + "\n"], { type: "text/csv" }));
    link.download = "exclude.csv";
    link.click();
  };
  again();
})();
