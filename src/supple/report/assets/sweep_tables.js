// The table of cases, page by page, and the table of extremes.

const PAGE = 50;
const FEW_COLUMNS = 12;

function cell(text, kind = "", tag = "td") {
  return Object.assign(document.createElement(tag), { textContent: text, className: kind });
}

// A cell with the number of a case, linked to a time of its report if there is one.
function caseCell(cases, row, instant, text) {
  const found = cell("", "number"),
    label = text ?? String(cases.columns[0].values[row]);
  const address = cases.reports[cases.columns[0].values[row]];
  if (!address) found.textContent = label;
  else {
    const at = Number.isFinite(instant) ? `#t=${instant}` : "";
    found.append(Object.assign(document.createElement("a"), { href: address + at, textContent: label }));
  }
  return found;
}

class CaseTable {
  constructor(cases, changed, picked) {
    this.cases = cases;
    this.changed = changed;
    this.picked = picked;
    this.page = 0;
    this.row = null;
    this.shown = new Set(cases.columns.keys().filter((place) => place < FEW_COLUMNS));
    const own = element("cases");
    this.head = own.querySelector("thead");
    this.body = own.querySelector("tbody");
    const choices = cases.columns.map((column, place) => {
      const label = document.createElement("label"),
        box = Object.assign(document.createElement("input"), { type: "checkbox", checked: this.shown.has(place) });
      box.onchange = () => {
        if (box.checked) this.shown.add(place);
        else this.shown.delete(place);
        this.drawHead();
        this.draw();
      };
      label.append(box, ` ${column.label}`);
      return label;
    });
    element("columns").querySelector("div").replaceChildren(...choices);
    own.querySelectorAll("[data-page]").forEach((button) => {
      button.onclick = () => {
        this.page += +button.dataset.page;
        this.draw();
      };
    });
    element("clear").onclick = () => {
      cases.filters.clear();
      cases.choose();
      this.drawHead();
      this.update();
    };
    this.drawHead();
    this.draw();
  }

  get places() {
    return [...this.shown].sort((a, b) => a - b);
  }

  drawHead() {
    const heads = document.createElement("tr"),
      filters = document.createElement("tr");
    for (const place of this.places) {
      const column = this.cases.columns[place],
        button = cell("", "", "button"),
        head = document.createElement("th"),
        input = document.createElement("input");
      button.textContent = column.label + this.arrow(place);
      button.onclick = () => {
        this.cases.sort(place);
        this.drawHead();
        this.update();
      };
      head.append(button);
      heads.append(head);
      input.value = this.cases.filters.get(place)?.text ?? "";
      input.setAttribute("aria-label", `filter of ${column.label}`);
      input.oninput = () => this.filter(place, input);
      const under = document.createElement("th");
      under.append(input);
      filters.append(under);
    }
    this.head.replaceChildren(heads, filters);
  }

  arrow(place) {
    const { column, rises } = this.cases.order;
    return column === place ? (rises ? " \u25b2" : " \u25bc") : "";
  }

  filter(place, input) {
    const understood = this.cases.filter(place, input.value);
    input.setCustomValidity(understood ? "" : "> 3, < 3, = 3 or 1 .. 3");
    if (!understood) return;
    const test = this.cases.filters.get(place);
    if (test) test.text = input.value;
    this.update();
  }

  update() {
    this.page = 0;
    this.draw();
    this.changed();
  }

  pick(row) {
    this.row = row;
    const place = this.cases.rows.indexOf(row);
    if (place >= 0) this.page = Math.floor(place / PAGE);
    this.draw();
  }

  draw() {
    const { rows, columns, number } = this.cases,
      pages = Math.max(1, Math.ceil(rows.length / PAGE));
    this.page = Math.min(Math.max(this.page, 0), pages - 1);
    element("count").textContent = `${rows.length} of ${number} ${this.cases.rowName}`;
    element("page").textContent = `page ${this.page + 1} of ${pages}`;
    const shown = rows.slice(this.page * PAGE, (this.page + 1) * PAGE).map((row) => {
      const line = document.createElement("tr");
      line.classList.toggle("picked", row === this.row);
      line.onclick = () => this.picked(row);
      for (const place of this.places) {
        const column = columns[place];
        line.append(
          place === 0 ? caseCell(this.cases, row) : cell(this.cases.text(column, row), column.words ? "" : "number"),
        );
      }
      return line;
    });
    this.body.replaceChildren(...shown);
  }
}

// Smallest and largest value of each channel over the displayed cases.
function drawExtremes(cases, channels) {
  const extreme = ({ column, instant }, sign) => {
    const { values } = cases.columns[column];
    let best = -1;
    for (const row of cases.rows)
      if (!Number.isNaN(values[row]) && (best < 0 || sign * values[row] > sign * values[best])) best = row;
    if (best < 0) return [cell(""), cell(""), cell("")];
    const at = cases.columns[instant].values[best];
    return [cell(shownNumber(values[best], 6), "number"), caseCell(cases, best, at), cell(measured(at, head.time, 5), "number")];
  };
  const lines = channels.map((channel) => {
    const line = document.createElement("tr");
    line.append(cell(channel.name), cell(channel.unit), ...extreme(channel.smallest, -1), ...extreme(channel.largest, 1));
    return line;
  });
  element("extremes").querySelector("tbody").replaceChildren(...lines);
  element("extremes").hidden = !channels.length;
}
