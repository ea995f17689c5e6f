// Plots of a sweep: an output against any column, its exceedance, and load spectra.

const HEIGHT = 330;

function axisOf(label, size, words) {
  const ink = themeColour("--ink"),
    grid = { stroke: themeColour("--line"), width: 1 };
  const text = (value) => {
    if (value == null) return "";
    if (words) return Number.isInteger(value) ? (words[value] ?? "") : "";
    return shownNumber(value, 5);
  };
  return {
    stroke: ink,
    grid,
    ticks: grid,
    label,
    size,
    labelSize: 18,
    font: "11px system-ui",
    labelFont: "12px system-ui",
    values: (_, values) => values.map(text),
    // Words must not overlap: 7 pixels for a character.
    ...(words && { space: 10 + 7 * Math.max(...words.map((word) => String(word).length)) }),
  };
}

// Wide enough for all points; around one value where all are equal.
function rangeOf(_, low, high) {
  if (low == null) return [0, 1];
  const margin = low === high ? Math.abs(low) || 1 : 0.04 * (high - low);
  return [low - margin, high + margin];
}

class Plot {
  constructor(id) {
    this.place = element(id).querySelector(".plot");
    this.graph = null;
  }

  // Draws the whole plot anew.
  draw(options, data) {
    this.graph?.destroy();
    this.graph = new uPlot(
      {
        width: Math.max(260, this.place.clientWidth),
        height: HEIGHT,
        cursor: { drag: { x: true, y: true, uni: 20 } },
        legend: { show: data.length > 2 },
        ...options,
      },
      data,
      this.place,
    );
  }
}

const dots = (label, colour, size = 5) => ({
  label,
  stroke: colour,
  fill: colour,
  width: 0,
  paths: () => null,
  points: { show: true, size, width: 0, fill: colour, stroke: colour },
});

// Classes of a column, each with a colour: the values of the column if they are few, or equal parts of its range.
function classesOf(column) {
  if (!column) return null;
  const values = column.values.filter((value) => !Number.isNaN(value));
  const found = [...new Set(values)].sort((a, b) => a - b);
  if (found.length <= CURVES.length) {
    const text = (value) => (column.words ? column.words[value] : shownNumber(value, 5));
    return found.map((value, i) => ({ label: text(value), colour: CURVES[i], has: (x) => x === value }));
  }
  const low = found[0],
    width = (found[found.length - 1] - low) / RAMP.length;
  return RAMP.map((colour, i) => ({
    label: `${shownNumber(low + i * width, 3)} to ${shownNumber(low + (i + 1) * width, 3)}`,
    colour,
    has: (x) => Math.min(RAMP.length - 1, Math.floor((x - low) / width)) === i,
  }));
}

class Scatter extends Plot {
  constructor(cases, picked) {
    super("scatter");
    this.cases = cases;
    this.picked = picked;
    this.row = null;
  }

  show(x, y, colour) {
    const values = y.values,
      rows = this.cases.ascending(x).filter((row) => !Number.isNaN(values[row])),
      classes = classesOf(colour) ?? [{ label: y.label, colour: CURVES[0], has: () => true }];
    this.rows = rows;
    this.x = x;
    this.y = y;
    const series = classes.map((own) =>
      rows.map((row) => (own.has(colour ? colour.values[row] : 0) ? values[row] : null)),
    );
    this.draw(
      {
        scales: { x: { time: false, range: rangeOf }, y: { range: rangeOf } },
        axes: [axisOf(x.label, 40, x.words), axisOf(y.label, 68)],
        series: [{ label: x.label }, ...classes.map((own) => dots(own.label, own.colour, rows.length > 2000 ? 3 : 6))],
        legend: { show: Boolean(colour), live: false },
        hooks: { draw: [(graph) => this.ring(graph)] },
      },
      [rows.map((row) => x.values[row]), ...series],
    );
    const { over } = this.graph;
    let from = null;
    over.addEventListener("pointerdown", (event) => (from = [event.offsetX, event.offsetY]));
    over.addEventListener("pointerup", (event) => {
      if (from && Math.hypot(event.offsetX - from[0], event.offsetY - from[1]) < 4)
        this.pickAt(event.offsetX, event.offsetY);
      from = null;
    });
  }

  // The nearest case within 24 pixels.
  pickAt(left, top) {
    let best = null,
      nearest = 24;
    for (const row of this.rows) {
      const far = Math.hypot(
        this.graph.valToPos(this.x.values[row], "x") - left,
        this.graph.valToPos(this.y.values[row], "y") - top,
      );
      if (far < nearest) [best, nearest] = [row, far];
    }
    if (best !== null) this.picked(best);
    return best;
  }

  ring(graph) {
    if (this.row === null || !this.rows.includes(this.row)) return;
    const pen = graph.ctx;
    pen.beginPath();
    pen.arc(
      graph.valToPos(this.x.values[this.row], "x", true),
      graph.valToPos(this.y.values[this.row], "y", true),
      8 * uPlot.pxRatio,
      0,
      2 * Math.PI,
    );
    pen.strokeStyle = themeColour("--ink");
    pen.lineWidth = 2 * uPlot.pxRatio;
    pen.stroke();
  }
}

class Exceedance extends Plot {
  constructor(cases) {
    super("exceedance");
    this.cases = cases;
  }

  show(column) {
    const rows = this.cases.ascending(column),
      n = rows.length;
    this.values = rows.map((row) => column.values[row]);
    this.shares = rows.map((_, i) => (n - i) / (n + 1));
    this.draw(
      {
        scales: { x: { time: false, range: rangeOf }, y: { distr: 3 } },
        axes: [axisOf(column.label, 40), axisOf(`share of ${this.cases.rowName}`, 68)],
        series: [
          { label: column.label },
          { label: "exceedance", stroke: CURVES[1], width: 1.5, points: { show: n < 60, size: 5 } },
        ],
      },
      [this.values, this.shares],
    );
  }
}

class Spectrum extends Plot {
  constructor(spectra, block) {
    super("spectrum");
    this.spectra = spectra.map((each) => ({
      ...each,
      ranges: Array.from(arrayOf(block, each.ranges)),
      counts: Array.from(arrayOf(block, each.counts)),
    }));
  }

  // exponent : of the shares of damage; NaN for cumulated cycles
  show(number, exponent) {
    const { ranges, counts, name, unit } = this.spectra[number],
      damages = counts.map((count, i) => count * (ranges[i] / ranges[ranges.length - 1]) ** exponent),
      total = damages.reduce((sum, each) => sum + each, 0);
    const cumulated = counts.map((_, i) => counts.slice(i).reduce((sum, each) => sum + each, 0));
    const cycles = Number.isNaN(exponent);
    this.values = cycles ? cumulated : damages.map((each) => each / total);
    const label = unit ? `range of ${name} (${unit})` : `range of ${name}`;
    this.draw(
      {
        scales: { x: { time: false, distr: 3 }, y: cycles ? { distr: 3 } : { range: (_, __, high) => [0, 1.05 * high] } },
        axes: [axisOf(label, 40), axisOf(cycles ? "cycles of at least this range" : "share of the damage", 68)],
        series: [
          { label },
          {
            label: cycles ? "cycles" : "damage",
            stroke: CURVES[2],
            fill: cycles ? undefined : `${CURVES[2]}66`,
            width: 1.5,
            paths: cycles ? uPlot.paths.stepped({ align: 1 }) : uPlot.paths.bars({ size: [0.9, 30] }),
            points: { show: false },
          },
        ],
      },
      [ranges, this.values],
    );
  }
}
