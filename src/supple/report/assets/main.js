// The controls of the page, and the objects for other scripts (`window.report`).

const element = (id) => document.getElementById(id);

function say(message) {
  element("message").textContent = message;
  element("message").hidden = !message;
}

function options(select, entries) {
  select.replaceChildren(
    ...entries.map(([value, text]) => Object.assign(document.createElement("option"), { value, textContent: text })),
  );
}

// The choice of speeds, in units of the model's time per second.
function speeds(player) {
  const inSeconds = head.secondsPerTime,
    length = player.length;
  const real = inSeconds && length * inSeconds >= 1 && length * inSeconds <= 120;
  const entries =
    real && !player.clip.repeats
      ? SPEEDS.map((factor) => [factor / inSeconds, factor === 1 ? "real time" : `${factor} x real time`])
      : SECONDS.map((seconds) => [
          length / seconds,
          player.clip.repeats ? `one period in ${seconds} s` : `whole run in ${seconds} s`,
        ]);
  const usual = real && !player.clip.repeats ? 3 : player.clip.repeats ? 0 : 1;
  options(element("speed"), entries);
  element("speed").selectedIndex = usual;
  player.rate = entries[usual][0];
}

function connect(player, curves) {
  const { scene } = player,
    scales = Object.keys(scene.scales);
  options(element("colour"), [...scales.map((name) => [name, name]), ["", "none"]]);
  options(element("follow"), [["", "ground"], ...player.bodies.map((body, i) => [i, body.name])]);
  options(
    element("clip"),
    player.clips.map((clip, i) => [i, clip.name]),
  );
  element("clip-label").hidden = player.clips.length < 2;
  element("timeline").hidden = player.times.length < 2;
  const box = (name) => document.querySelector(`[data-show=${name}]`).parentElement;
  box("triads").hidden = box("joints").hidden = !scene.joints.length;
  for (const [name, kinds] of Object.entries(ARROWS)) {
    const longest = kinds.filter((kind) => player.marks.largest[kind] > 0);
    box(name).hidden = !longest.length;
    box(name).querySelector(".note").textContent = `longest ${longest
      .map((kind) => measured(player.marks.largest[kind], kind === "moment" ? head.moment : head.force))
      .join(", ")}`;
  }
  element("play").onclick = () => player.play();
  element("back").onclick = () => player.seekRow(player.row - 1);
  element("on").onclick = () => player.seekRow(player.row + 1);
  element("time").oninput = (event) => player.seek(event.target.value * player.length);
  element("speed").onchange = (event) => (player.rate = +event.target.value);
  element("loop").onchange = (event) => (player.looping = event.target.checked);
  element("gain").oninput = (event) => {
    player.gain = Math.max(0, +event.target.value || 0);
    player.dirty = true;
  };
  element("colour").onchange = (event) => {
    player.colour(event.target.value);
    showPicked(player, curves, true);
  };
  element("follow").onchange = (event) => player.follow(event.target.value === "" ? -1 : +event.target.value);
  element("clip").onchange = (event) => {
    player.choose(+event.target.value);
    speeds(player);
    showClip(player);
    showPicked(player, curves, true);
  };
  document
    .querySelectorAll("[data-view]")
    .forEach((button) => (button.onclick = () => player.view.look(button.dataset.view)));
  document.querySelectorAll("[data-show]").forEach(
    (box) =>
      (box.onchange = () => {
        player.shown[box.dataset.show] = box.checked;
        player.dirty = true;
      }),
  );
  player.looping = element("loop").checked;
  player.onplay = () => (element("play").textContent = player.playing ? "Pause" : "Play");
  player.ontime = () => {
    element("time").value = player.length ? player.time / player.length : 0;
    const time = scene.start + player.times[player.clip.first] + player.time;
    element("now").textContent = player.clip.repeats
      ? `phase ${Math.round((360 * player.time) / player.length) % 360}\u00b0`
      : `t = ${measured(time, head.time, 5)}`;
    showPicked(player, curves, false);
  };
  player.onpick = () => showPicked(player, curves, true);
  clicks(player);
  keys(player);
}

function showClip(player) {
  element("clip-note").textContent = player.clip.note;
}

// Error of a field value, if it is visible.
const within = ({ error }) => (error ? ` \u00b1 ${shownNumber(error, 2)}` : "");

// Description of the selected node; its history as a chart.
function showPicked(player, curves, anew) {
  const reading = player.reading(),
    box = element("picked");
  box.hidden = !reading;
  if (reading) {
    const { scales } = player.scene,
      unit = head.length,
      three = (values) => values.map((x) => shownNumber(x, 5)).join(", ");
    const fields = Object.entries(reading.fields).map(
      ([name, value]) => `${scales[name].label}: ${shownNumber(value)}${within(scales[name])}`,
    );
    box.textContent = [
      `node ${reading.node} of ${reading.body}`,
      ...fields,
      `deflection x, y, z: ${three(reading.displacement)}${unit ? ` ${unit}` : ""}`,
      `seen from ${reading.seenFrom}`,
      `at ${three(reading.position)}${unit ? ` ${unit}` : ""}`,
    ].join("\n");
  }
  if (!anew) return;
  if (player.chart) curves.remove(player.chart);
  player.chart = reading && player.clip.number > 1 ? curves.add(player.history(), true, true) : null;
}

// A click, and not the end of a drag.
function clicks(player) {
  const { canvas } = player.view;
  let from = null;
  canvas.addEventListener("pointerdown", (event) => (from = [event.offsetX, event.offsetY]));
  canvas.addEventListener("pointerup", (event) => {
    if (from && Math.hypot(event.offsetX - from[0], event.offsetY - from[1]) < 4)
      player.pick(event.offsetX, event.offsetY);
    from = null;
  });
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    say("The browser lost the graphics unit; the picture returns when the graphics unit is available again.");
  });
  canvas.addEventListener("webglcontextrestored", () => {
    say("");
    player.dirty = true;
  });
  window.addEventListener("beforeprint", () => {
    player.draw();
    element("still").src = canvas.toDataURL("image/png");
  });
}

function keys(player) {
  const press = (id) => () => element(id).click();
  const actions = {
    " ": () => player.play(),
    ArrowLeft: press("back"),
    ArrowRight: press("on"),
    l: press("loop"),
    L: press("loop"),
    Home: () => player.seek(0),
    End: () => player.seekRow(player.clip.number - 1),
    Escape: () => player.pick(NaN, NaN),
  };
  for (const [key, view] of Object.entries({ f: "fit", x: "+x", y: "+y", z: "+z", X: "-x", Y: "-y", Z: "-z" }))
    actions[key] = () => player.view.look(view);
  document.addEventListener("keydown", (event) => {
    if (
      event.ctrlKey ||
      event.metaKey ||
      event.altKey ||
      ["INPUT", "SELECT", "SUMMARY", "BUTTON"].includes(event.target.tagName)
    )
      return;
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });
}

// The time at the end of an address, such as report.html#t=4.2, from the start of the motion.
function instantOf(hash, player) {
  const instant = parseFloat(hash.replace(/^#t=/, ""));
  return Number.isNaN(instant) ? 0 : instant - player.scene.start - player.times[player.clip.first];
}

async function start() {
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  setTheme(dark.matches);
  const block = await inflated();
  let player = null;
  const curves = new Curves(element("charts"), (time) =>
    player?.seek(time - player.scene.start - player.times[player.clip.first]),
  );
  const changeTheme = (to) => {
    setTheme(to);
    curves.redraw();
    if (player) player.dirty = true;
  };
  dark.addEventListener("change", (event) => changeTheme(event.matches));
  element("theme").onclick = () => changeTheme(!isDark());
  document.addEventListener("keydown", (event) => {
    if (event.key === "d" && !event.ctrlKey && !event.metaKey && event.target.tagName !== "INPUT")
      changeTheme(!isDark());
  });
  if (head.scene) {
    element("player").hidden = false;
    document.body.classList.add("played");
    player = new Player(head.scene, block, curves);
    try {
      player.build();
      connect(player, curves);
      speeds(player);
      showClip(player);
      player.seek(instantOf(window.location.hash, player));
    } catch (error) {
      say(`This browser has no WebGL 2, which the motion needs; curves and tables are shown. (${error.message})`);
      element("controls").hidden = true;
      player = null;
    }
  }
  head.charts.forEach((chart, number) => {
    const values = arrayOf(block, chart.curves),
      [, columns] = chart.curves.shape;
    curves.add(
      {
        ...chart,
        abscissa: Array.from(arrayOf(block, chart.abscissa)),
        columns: chart.names.map((_, i) =>
          Array.from(values.subarray(i * columns, (i + 1) * columns), (x) => (Number.isNaN(x) ? null : x)),
        ),
      },
      number < 3,
    );
  });
  window.report = { player, curves };
}

start().catch((error) => {
  element("player").hidden = false;
  say(
    typeof DecompressionStream === "undefined"
      ? "This browser is too old to show the motion and the curves; the tables are below."
      : `The motion cannot be shown: ${error.message}`,
  );
  element("controls").hidden = true;
});
