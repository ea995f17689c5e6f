// Colours of values and of objects, in light and dark mode.

// Viridis at nine points, with monotonic brightness.
const RAMP = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
const CURVES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a"];

const themeColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const isDark = () => document.documentElement.dataset.theme === "dark";

function setTheme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
}

function drawLegend(scale) {
  document.getElementById("legend").hidden = !scale;
  if (!scale) return;
  document.getElementById("legend-label").textContent = scale.label;
  const ramp = document.getElementById("ramp"),
    pen = ramp.getContext("2d");
  const gradient = pen.createLinearGradient(0, ramp.height, 0, 0);
  RAMP.forEach((colour, i) => gradient.addColorStop(i / (RAMP.length - 1), colour));
  pen.fillStyle = gradient;
  pen.fillRect(0, 0, ramp.width, ramp.height);
  const digits = 2 - Math.floor(Math.log10(scale.high || 1)),
    fixed = digits >= 0 && digits < 7;
  const ticks = [1, 0.75, 0.5, 0.25, 0].map((share) => {
    const tick = document.createElement("span");
    const value = scale.low + share * (scale.high - scale.low);
    tick.textContent = fixed ? value.toFixed(digits) : shownNumber(value, 3);
    return tick;
  });
  document.getElementById("ticks").replaceChildren(...ticks);
}
