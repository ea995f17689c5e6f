// The page of a sweep, and the object for other scripts (`window.sweep`).

const { uPlot } = Libraries;
const element = (id) => document.getElementById(id);
const choice = (name) => document.querySelector(`[data-choice=${name}]`);

function options(select, entries) {
  select.replaceChildren(
    ...entries.map(([value, text]) => Object.assign(document.createElement("option"), { value, textContent: text })),
  );
}

// The first column of a kind whose values differ, or the first of the kind.
function telling(columns, kind) {
  const own = columns.map((column, place) => [column, place]).filter(([column]) => column.kind === kind);
  const differs = ([{ values }]) => values.some((value) => value !== values[0] && !Number.isNaN(value));
  return (own.find(differs) ?? own[0] ?? [null, 0])[1];
}

class Sweep {
  constructor(data, block) {
    this.cases = new Cases(data, block);
    this.channels = data.channels;
    for (const own of document.querySelectorAll(".rows")) own.textContent = data.rows;
    element("extremes").hidden = !data.channels.length;
    const { columns } = this.cases,
      entries = columns.map((column, place) => [place, column.label]);
    options(choice("x"), entries);
    options(
      choice("y"),
      entries.filter(([place]) => !columns[place].words),
    );
    options(choice("colour"), [["", "none"], ...entries]);
    choice("x").value = telling(columns, "parameter");
    choice("y").value = telling(columns, "output");
    this.scatter = new Scatter(this.cases, (row) => this.pick(row));
    this.exceedance = new Exceedance(this.cases);
    this.table = new CaseTable(
      this.cases,
      () => this.draw(),
      (row) => this.pick(row),
    );
    for (const name of ["x", "y", "colour"]) choice(name).onchange = () => this.drawCases();
    element("spectrum").hidden = !data.spectra.length;
    this.spectrum = data.spectra.length ? new Spectrum(data.spectra, block) : null;
    options(
      choice("channel"),
      data.spectra.map(({ name }, i) => [i, name]),
    );
    options(choice("measure"), [
      ["NaN", "cumulated cycles"],
      ...data.exponents.map((m) => [m, `shares of damage, m = ${m}`]),
    ]);
    for (const name of ["channel", "measure"]) choice(name).onchange = () => this.drawSpectrum();
    this.draw();
    this.drawSpectrum();
  }

  draw() {
    this.drawCases();
    drawExtremes(this.cases, this.channels);
  }

  drawCases() {
    const { columns } = this.cases,
      at = (name) => (choice(name).value === "" ? null : columns[+choice(name).value]);
    this.scatter.show(at("x"), at("y"), at("colour"));
    this.exceedance.show(at("y"));
  }

  drawSpectrum() {
    this.spectrum?.show(+choice("channel").value, +choice("measure").value);
  }

  pick(row) {
    const { cases, scatter } = this;
    scatter.row = row;
    scatter.graph.redraw(false);
    this.table.pick(row);
    const parts = cases.columns
      .filter((column, place) => column.kind === "parameter" || column === scatter.x || column === scatter.y || !place)
      .map((column) => `${column.label} ${cases.text(column, row)}`);
    element("chosen").textContent = parts.join(", ");
  }

  redraw() {
    this.drawCases();
    this.drawSpectrum();
  }
}

async function start() {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let sweep = null;
  const changeTheme = (to) => {
    setTheme(to);
    sweep?.redraw();
  };
  changeTheme(dark.matches);
  dark.addEventListener("change", (event) => changeTheme(event.matches));
  element("theme").onclick = () => changeTheme(!isDark());
  document.addEventListener("keydown", (event) => {
    if (event.key === "d" && !event.ctrlKey && !event.metaKey && !["INPUT", "SELECT"].includes(event.target.tagName))
      changeTheme(!isDark());
  });
  const block = await inflated();
  element("sweep").hidden = false;
  sweep = new Sweep(head.sweep, block);
  let waiting = null;
  window.addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => sweep.redraw(), 150);
  });
  window.sweep = sweep;
}

start().catch((error) => {
  element("message").hidden = false;
  element("message").textContent =
    typeof DecompressionStream === "undefined"
      ? "This browser is too old to show the cases."
      : `The cases cannot be shown: ${error.message}`;
});
