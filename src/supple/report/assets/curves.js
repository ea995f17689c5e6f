// Curves: a chart is drawn when it is opened. A chart over time shows the time of the player; a click sets this time.

// A constant curve is drawn in the middle of its axis.
function valueRange(_, low, high) {
  const around = low === high ? Math.abs(low) || 1 : 0;
  return uPlot.rangeNum(low - around, high + around, 0.1, true);
}

class Curves {
  constructor(list, seek) {
    this.list = list;
    this.seek = seek;
    this.charts = [];
    this.now = null;
  }

  // data : {title, note, label, over, abscissa, names, columns}; over is empty where the abscissa is the time
  add(data, open, first = false) {
    const details = document.createElement("details"),
      summary = document.createElement("summary"),
      plot = document.createElement("div");
    summary.textContent = data.title;
    plot.className = "plot";
    details.append(summary, plot);
    if (data.note) {
      const note = document.createElement("div");
      note.className = "note";
      note.textContent = data.note;
      details.append(note);
    }
    const chart = { data, details, plot, graph: null };
    details.addEventListener("toggle", () => this.draw(chart));
    if (first) {
      this.list.prepend(details);
      this.charts.unshift(chart);
    } else {
      this.list.append(details);
      this.charts.push(chart);
    }
    details.open = open;
    this.list.hidden = false;
    document.body.classList.add("charted");
    return chart;
  }

  remove(chart) {
    chart.graph?.destroy();
    chart.details.remove();
    this.charts = this.charts.filter((each) => each !== chart);
  }

  draw(chart) {
    if (!chart.details.open || chart.graph) return;
    const { data, plot } = chart,
      ink = themeColour("--ink"),
      grid = { stroke: themeColour("--line"), width: 1 };
    const axis = (label) => ({
      stroke: ink,
      grid,
      ticks: grid,
      label,
      labelSize: 18,
      font: "11px system-ui",
      labelFont: "12px system-ui",
    });
    const ticks = (_, values) => values.map((each) => (each == null ? "" : shownNumber(each, 5)));
    const shown = (_, value) => (value == null ? "" : shownNumber(value));
    const tip = document.createElement("div");
    tip.className = "tip";
    tip.hidden = true;
    chart.graph = new uPlot(
      {
        width: Math.max(260, plot.clientWidth || this.list.clientWidth - 8),
        height: document.body.classList.contains("played") ? 190 : 420,
        scales: { x: { time: false }, y: { range: valueRange } },
        axes: [
          { ...axis(data.over || timeLabel()), size: 34, values: ticks },
          { ...axis(data.label), size: 64, values: ticks },
        ],
        series: [
          { label: data.over || timeLabel(), value: shown },
          ...data.names.map((label, i) => ({
            label,
            stroke: CURVES[i % CURVES.length],
            width: 1.4,
            value: shown,
            dash: i < CURVES.length ? [] : [6, 4],
            points: { show: data.abscissa.length < 30 },
          })),
        ],
        focus: { alpha: 0.35 },
        cursor: { focus: { prox: 24 }, drag: { x: true, y: false } },
        hooks: {
          ready: [() => this.showOn(chart)],
          setSeries: [(graph, number) => this.tell(graph, tip, number)],
          setCursor: [
            (graph) => {
              if (graph.cursor.left < 0) tip.hidden = true;
            },
          ],
        },
      },
      [data.abscissa, ...data.columns],
      plot,
    );
    chart.graph.over.append(tip);
    if (data.over) return;
    chart.line = document.createElement("div");
    chart.line.className = "cursor-line";
    chart.graph.over.append(chart.line);
    chart.graph.over.addEventListener("click", (event) => this.seek(chart.graph.posToVal(event.offsetX, "x")));
  }

  // The name of the curve at the pointer, and its value there.
  tell(graph, tip, number) {
    const place = graph.cursor.idx;
    tip.hidden = number == null || place == null || graph.data[number]?.[place] == null;
    if (tip.hidden) return;
    tip.textContent = `${graph.series[number].label}: ${shownNumber(graph.data[number][place])}`;
    tip.style.left = `${graph.cursor.left + 10}px`;
    tip.style.top = `${graph.cursor.top - 24}px`;
  }

  showTime(time) {
    this.now = time;
    for (const chart of this.charts) this.showOn(chart);
  }

  showOn({ data, graph, line, details }) {
    if (!graph || !line || !details.open || this.now === null) return;
    line.style.left = `${graph.valToPos(this.now, "x")}px`;
    if (graph.cursor.left < 0) graph.setLegend({ idx: rowAt(data.abscissa, this.now) }, false);
  }

  redraw() {
    for (const chart of this.charts) {
      chart.graph?.destroy();
      chart.graph = null;
      this.draw(chart);
    }
  }
}

const timeLabel = () => (head.time ? `time (${head.time})` : "time");

// The row of ascending numbers that is nearest to a value.
function rowAt(values, value) {
  let low = 0,
    high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value) low = middle;
    else high = middle;
  }
  return value - values[low] < values[high] - value ? low : high;
}
