// The cases of a sweep, stored by column; the rows that are shown, and their order.

class Cases {
  constructor(sweep, block) {
    this.columns = sweep.columns.map((column) => ({ ...column, values: arrayOf(block, column.values) }));
    this.number = sweep.number;
    this.rowName = sweep.rows;
    this.reports = sweep.reports;
    this.filters = new Map();
    this.order = { column: 0, rises: true };
    this.choose();
  }

  // A value as text, "" if missing.
  text(column, row) {
    const value = column.values[row];
    if (Number.isNaN(value)) return "";
    return column.words ? column.words[value] : column.whole ? String(value) : shownNumber(value, 6);
  }

  // False if the text is not a valid filter of the column.
  filter(place, text) {
    const test = text.trim() ? filterOf(this.columns[place], text.trim()) : null;
    if (test === undefined) return false;
    if (test) this.filters.set(place, test);
    else this.filters.delete(place);
    this.choose();
    return true;
  }

  sort(place) {
    this.order = { column: place, rises: this.order.column !== place || !this.order.rises };
    this.choose();
  }

  // Rows that pass all filters, in order; cases without a value come last.
  choose() {
    const tests = [...this.filters].map(([place, test]) => [this.columns[place].values, test]);
    const rows = [];
    for (let row = 0; row < this.number; row++)
      if (tests.every(([values, test]) => test(values[row]))) rows.push(row);
    const { values } = this.columns[this.order.column],
      sign = this.order.rises ? 1 : -1;
    this.rows = rows.sort((a, b) => {
      const none = Number.isNaN(values[a]) - Number.isNaN(values[b]);
      return none || sign * (values[a] - values[b]) || a - b;
    });
  }

  // Rows that are shown and have a value, from the smallest value to the largest.
  ascending(column) {
    const { values } = column;
    return this.rows.filter((row) => !Number.isNaN(values[row])).sort((a, b) => values[a] - values[b] || a - b);
  }
}

const NUMBER = String.raw`[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?`;
const COMPARED = new RegExp(`^(>=|<=|>|<|=)\\s*(${NUMBER})$`, "i");
const BETWEEN = new RegExp(`^(${NUMBER})\\s*\\.\\.\\s*(${NUMBER})$`, "i");
const ALONE = new RegExp(`^${NUMBER}$`, "i");
// Values with equal display are equal, except for integers.
const alike = (column, bound) => {
  const text = shownNumber(bound, 6);
  return (x) => x === bound || (!column.whole && shownNumber(x, 6) === text);
};
const COMPARISONS = {
  ">": (bound) => (x) => x > bound,
  "<": (bound) => (x) => x < bound,
  ">=": (bound) => (x) => x >= bound,
  "<=": (bound) => (x) => x <= bound,
};

// A test of values; undefined if the text is invalid.
function filterOf(column, text) {
  if (column.words) {
    const sought = text.toLowerCase();
    const passes = column.words.map((word) => word.toLowerCase().includes(sought));
    return (code) => Boolean(passes[code]);
  }
  const compared = COMPARED.exec(text);
  if (compared) return compared[1] === "=" ? alike(column, +compared[2]) : COMPARISONS[compared[1]](+compared[2]);
  const between = BETWEEN.exec(text);
  if (between) return (x) => x >= +between[1] && x <= +between[2];
  return ALONE.test(text) ? alike(column, +text) : undefined;
}
