// SPDX-License-Identifier: GPL-3.0-only
// The page: what the user chooses, and what is shown of it. `window.explorer` is the same for scripts.

// ColorBrewer's RdBu and YlGnBu, which the colour-blind can read.
const DIVERGING = [
  [33, 102, 172], [67, 147, 195], [146, 197, 222], [209, 229, 240], [247, 247, 247], [253, 219, 199], [244, 165, 130], [214, 96, 77],
  [178, 24, 43],
];
const SEQUENTIAL = [
  [255, 255, 217], [237, 248, 177], [199, 233, 180], [127, 205, 187], [65, 182, 196], [29, 145, 192], [34, 94, 168], [37, 52, 148],
  [8, 29, 88],
];
const PLAIN = [[203, 213, 224], [203, 213, 224]];
const REACH = 4; // of the sliders, in standard deviations
const SWING = 3; // of a mode that is played
const SECONDS_PER_SWING = 4;
const MEAN = "mean"; // the value of this choice in lists of shapes

const element = (id) => document.getElementById(id);

function made(tag, properties = {}, children = []) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

/** With a true minus; three digits, or as many decimals as are asked for. */
function shown(number, decimals) {
  const text = decimals === undefined ? String(Number(number.toPrecision(3))) : number.toFixed(decimals);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
}

/** The next larger of 1, 1.5, 2, 3, 4, 5, 6, 8, times a power of ten. */
function roundedUp(number) {
  if (!(number > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(number) + 1e-9);
  return power * ([1, 1.5, 2, 3, 4, 5, 6, 8].find((step) => step * power >= number * (1 - 1e-9)) || 10);
}

class Explorer {
  constructor(data) {
    this.data = data;
    this.model = new ShapeModel(data);
    const { landmarks, modes } = this.model;
    this.scores = new Float64Array(modes);
    this.shape = new Float64Array(3 * landmarks);
    this.positions = new Float32Array(3 * landmarks);
    this.normals = new Float32Array(3 * landmarks);
    this.values = new Float32Array(landmarks);
    this.distances = new Float64Array(landmarks);
    this.fixed = new Map(); // index -> target, relative to the centre
    this.noise = data.noise;
    this.factor = this.model.posterior([], 1).factor; // of what is fixed
    this.uncertainty = null; // per landmark, where it was asked for since something was fixed
    this.chosen = MEAN; // of the list of shapes; null for scores of the user's own
    this.playing = null; // {mode, at} or {at}, in turns or shapes
    this.hovered = -1;
    this.partOf = data.parts ? decoded(data.parts) : null;
    const names = data.partNames;
    this.visible = names.map(() => true);
    const corners = names.map(() => []);
    for (let f = 0; f < this.model.faces.length; f += 3) {
      corners[this.part(this.model.faces[f])].push(...this.model.faces.subarray(f, f + 3));
    }
    this.renderer = new Renderer(element("surface"), landmarks, corners);
    let radius = 0;
    for (let i = 0; i < this.model.mean.length; i += 3) radius = Math.max(radius, Math.hypot(...this.model.mean.subarray(i, i + 3)));
    this.camera = new Camera(data.view, radius || 1);
    this.setUp();
    this.setColours("along");
    this.show(MEAN);
  }

  part(index) {
    return this.partOf ? this.partOf[index] : 0;
  }

  sees(index) {
    return this.visible[this.part(index)];
  }

  /** As the model that there was before lids were left out counts. */
  number(index) {
    return this.data.numbers ? this.data.numbers[index] : index;
  }

  numbered(number) {
    return this.data.numbers ? this.data.numbers.indexOf(number) : number < this.model.landmarks ? number : -1;
  }

  // ------------------------------------------------------------------ scores

  setScores(scores, chosen = null) {
    this.scores.set(scores);
    this.chosen = chosen;
    this.model.shape(this.scores, this.shape); // at once: a landmark may be picked before the picture
    this.changed();
  }

  setMode(mode, deviations) {
    const scores = Float64Array.from(this.scores);
    scores[mode] = deviations;
    this.setScores(scores);
  }

  /** The mean, or a training shape by its number. */
  show(which) {
    this.setScores(which === MEAN ? new Float64Array(this.model.modes) : this.model.scores[which], which);
  }

  step(by) {
    const count = this.model.names.length, at = typeof this.chosen === "number" ? this.chosen : by > 0 ? -1 : 0;
    this.stop();
    this.show((at + by + count) % count);
  }

  // ------------------------------------------------------------------ fixed landmarks

  /** target: in the model's own coordinates. */
  fix(index, target) {
    this.fixRelative(index, target.map((value, axis) => value - this.model.centre[axis]));
  }

  fixRelative(index, target) {
    this.stop();
    this.fixed.set(index, target);
    this.fit();
  }

  release(index) {
    if (index === undefined) this.fixed.clear();
    else this.fixed.delete(index);
    this.fit();
  }

  setNoise(noise) {
    if (!(noise >= this.data.leastNoise)) noise = this.data.leastNoise;
    this.noise = noise;
    element("noise").value = Number(noise.toPrecision(3));
    this.fit();
  }

  /** The most probable shape for what is fixed. */
  fit() {
    const fixed = Array.from(this.fixed, ([index, target]) => ({ index, target }));
    const { scores, factor } = this.model.posterior(fixed, this.noise);
    this.factor = factor;
    this.uncertainty = null;
    this.setScores(scores, this.fixed.size ? null : MEAN);
    this.listFixed();
  }

  listFixed() {
    const list = element("fixed");
    list.replaceChildren(
      ...Array.from(this.fixed.keys(), (index) =>
        made("li", {}, [
          made("b", { textContent: this.number(index) }),
          made("span", { id: `off-${index}`, className: "quiet" }),
          made("button", { textContent: "Unfix", ariaLabel: `Unfix landmark ${this.number(index)}`, onclick: () => this.release(index) }),
        ]),
      ),
    );
    element("unfix").hidden = element("again").hidden = !this.fixed.size;
  }

  // ------------------------------------------------------------------ playing

  play(mode) {
    const same = this.playing && this.playing.mode === mode;
    this.stop();
    if (same) return;
    const at = mode === undefined ? (typeof this.chosen === "number" ? this.chosen : 0) : this.phaseOf(mode);
    this.playing = { mode, at };
    this.markPlaying();
    this.last = undefined;
    this.changed();
  }

  /** Where in its swing a mode is, so that it begins where its slider stands. */
  phaseOf(mode) {
    return Math.asin(Math.min(1, Math.max(-1, this.scores[mode] / SWING))) / (2 * Math.PI);
  }

  stop() {
    if (!this.playing) return;
    this.playing = null;
    this.markPlaying();
  }

  markPlaying() {
    const mode = this.playing ? this.playing.mode : null;
    element("play").ariaPressed = String(mode === undefined);
    element("play").textContent = mode === undefined ? "Stop" : "Play";
    this.rows.forEach((row, m) => {
      row.play.ariaPressed = String(mode === m);
      row.play.textContent = mode === m ? "■" : "▶";
    });
  }

  advance(seconds) {
    const { playing } = this, speed = Number(element("speed").value);
    if (playing.mode !== undefined) {
      playing.at += (speed * seconds) / SECONDS_PER_SWING;
      this.scores[playing.mode] = SWING * Math.sin(2 * Math.PI * playing.at);
      this.chosen = null;
      return;
    }
    const count = this.model.names.length, cyclic = element("cycle").checked, turn = cyclic ? count : count - 1;
    playing.at = turn ? (playing.at + speed * seconds * this.data.perSecond) % turn : 0;
    const first = Math.floor(playing.at), share = playing.at - first;
    const from = this.model.scores[first], to = this.model.scores[(first + 1) % count];
    for (let m = 0; m < this.model.modes; ++m) this.scores[m] = (1 - share) * from[m] + share * to[m];
    this.chosen = (first + Math.round(share)) % count;
  }

  // ------------------------------------------------------------------ colours

  setColours(colours, reference = MEAN) {
    this.colours = colours;
    this.reference = reference;
    this.referenceShape = reference === MEAN ? this.model.mean : this.model.shape(this.model.scores[reference]);
    this.referenceNormals = reference === MEAN ? this.model.normals : vertexNormals(this.referenceShape, this.model.faces);
    element("colours").value = colours;
    element("reference").value = reference;
    element("comparison").style.visibility = colours === "along" || colours === "distance" ? "" : "hidden";
    this.renderer.setPalette(this.palette());
    this.reach = this.findReach();
    this.describeColours();
    this.changed();
  }

  palette() {
    return { along: DIVERGING, none: PLAIN }[this.colours] || SEQUENTIAL;
  }

  /** What full colour is: a scale that does not change while things move. */
  findReach() {
    if (this.colours === "none") return 1;
    if (this.colours === "uncertainty") {
      return roundedUp(Math.max(...this.model.uncertainty(this.model.posterior([], 1).factor)));
    }
    const { model } = this, shape = new Float64Array(this.shape.length), ends = [];
    const stride = Math.ceil(model.scores.length / 200) || 1;
    for (let k = 0; k < model.scores.length; k += stride) ends.push(model.scores[k]);
    if (model.modes) for (const end of [-2, 2]) ends.push(Float64Array.from(model.scores[0], (_, m) => (m ? 0 : end)));
    let most = 0;
    for (const scores of ends) {
      for (const distance of this.measured(model.shape(scores, shape))) most = Math.max(most, Math.abs(distance));
    }
    return roundedUp(most);
  }

  measured(shape) {
    const normals = this.colours === "along" ? this.referenceNormals : null;
    return this.model.distances(shape, this.referenceShape, normals, this.distances);
  }

  describeColours() {
    const { unit } = this.data, name = this.reference === MEAN ? "the mean" : this.model.names[this.reference];
    element("legend").hidden = this.colours === "none";
    element("legend-title").textContent = {
      along: `Distance to ${name}, along its normal`,
      distance: `Distance to ${name}`,
      uncertainty: "Standard deviation that is left",
    }[this.colours] || "";
    const reach = shown(this.reach);
    const ticks = this.colours === "along" ? [`\u2212${reach} ${unit} inwards`, "0", `+${reach} ${unit} outwards`] : ["0", `${shown(this.reach / 2)}`, `${reach} ${unit}`];
    element("ticks").replaceChildren(...ticks.map((textContent) => made("span", { textContent })));
    const stops = this.palette().map((color) => `rgb(${color.join(" ")})`);
    element("bar").style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  }

  /** Of the landmarks, what the colours show. */
  colouredValues() {
    if (this.colours !== "uncertainty") return this.measured(this.shape);
    this.uncertainty = this.uncertainty || this.model.uncertainty(this.factor);
    return this.uncertainty;
  }

  // ------------------------------------------------------------------ drawing

  /** Something is to be drawn anew, with the next picture of the screen. */
  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      if (this.playing) {
        this.advance(Math.min(0.1, (now - (this.last === undefined ? now : this.last)) / 1000));
        this.model.shape(this.scores, this.shape);
        this.last = now;
      }
      this.update();
      if (this.playing) this.changed();
    });
  }

  update() {
    this.positions.set(this.shape);
    vertexNormals(this.positions, this.model.faces, this.normals);
    if (this.colours === "none") this.values.fill(0.5);
    else {
      const found = this.colouredValues(), signed = this.colours === "along";
      let most = 0;
      for (let j = 0; j < found.length; ++j) {
        this.values[j] = signed ? 0.5 + (0.5 * found[j]) / this.reach : found[j] / this.reach;
        most = Math.max(most, Math.abs(found[j]));
      }
      const beyond = most > this.reach * (1 + 1e-9) ? ": beyond the scale" : "";
      setText(element("legend-now"), `at most ${shown(most)} ${this.data.unit} now${beyond}`);
    }
    this.renderer.setShape(this.positions, this.normals, this.values);
    this.renderer.draw(this.camera, this.visible, element("dots").checked || !this.model.faces.length ? 5 : 0);
    this.drawOverlay();
    this.tell();
  }

  /** Fixed landmarks with the way that is left to them, and the one under the mouse. */
  drawOverlay() {
    const canvas = element("overlay"), ratio = Math.min(window.devicePixelRatio || 1, 2), { size } = this.renderer;
    const [w, h] = [Math.round(size.width * ratio), Math.round(size.height * ratio)];
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    else if (!this.overlaid && this.hovered < 0 && !this.fixed.size) return;
    this.overlaid = this.hovered >= 0 || this.fixed.size > 0;
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, size.width, size.height);
    pen.font = '600 13px system-ui, "DejaVu Sans", sans-serif';
    const ring = (x, y, radius, fill) => {
      pen.beginPath();
      pen.arc(x, y, radius, 0, 2 * Math.PI);
      if (fill) [pen.fillStyle = fill, pen.fill()];
      [pen.lineWidth, pen.strokeStyle] = [2, "#fff"];
      pen.stroke();
      pen.beginPath();
      pen.arc(x, y, radius + 1.5, 0, 2 * Math.PI);
      [pen.lineWidth, pen.strokeStyle] = [1.5, "#1c2530"];
      pen.stroke();
    };
    for (const [index, target] of this.fixed) {
      if (!this.sees(index)) continue;
      const [x, y] = this.camera.project(target, size), [u, v] = this.camera.project(this.place(index), size);
      pen.beginPath();
      pen.moveTo(u, v);
      pen.lineTo(x, y);
      [pen.lineWidth, pen.strokeStyle] = [2, "#b9480a"];
      pen.stroke();
      ring(x, y, 5, "#e8701a");
      [pen.lineWidth, pen.strokeStyle, pen.fillStyle] = [3.5, "#fff", "#1c2530"];
      pen.strokeText(this.number(index), x + 11, y - 7);
      pen.fillText(this.number(index), x + 11, y - 7);
    }
    if (this.hovered >= 0 && !this.fixed.has(this.hovered)) ring(...this.camera.project(this.place(this.hovered), size).slice(0, 2), 4);
  }

  place(index) {
    return Array.from(this.shape.subarray(3 * index, 3 * index + 3));
  }

  /** What the side of the page says of the scores. */
  tell() {
    this.rows.forEach((row, m) => {
      const score = this.scores[m];
      if (row.told === score) return;
      row.told = score;
      if (Number(row.slider.value) !== score) row.slider.value = score;
      row.slider.ariaValueText = `${score.toFixed(2)} standard deviations`;
      setText(row.output, shown(score, Math.abs(score) < 10 ? 2 : 1));
      row.line.classList.toggle("far", Math.abs(score) > 3);
    });
    if (this.model.modes) {
      const typical = Math.sqrt(Math.max(this.model.modes - 0.5, 0.64));
      const distance = shown(mahalanobis(this.scores), 2);
      setText(element("deviation"), `Mahalanobis ${distance}, at random ${shown(typical, 1)}`);
    }
    const shapes = element("shapes"), value = this.chosen === null ? "own" : String(this.chosen);
    if (shapes.value !== value) shapes.value = value;
    if (this.chosen !== null) element("time").value = this.chosen === MEAN ? 0 : this.chosen;
    for (const [index, target] of this.fixed) {
      const off = Math.hypot(...this.place(index).map((coordinate, axis) => coordinate - target[axis]));
      setText(element(`off-${index}`), `${shown(off)} ${this.data.unit} off its place`);
    }
    if (this.hovered >= 0) this.describe(this.hovered);
  }

  describe(index) {
    const { unit, centre } = this.data;
    const where = this.place(index).map((value, axis) => shown(value + centre[axis], 2)).join(", ");
    const lines = [`landmark ${this.number(index)}` + (this.visible.length > 1 ? `, ${this.data.partNames[this.part(index)]}` : ""), `${where} ${unit}`];
    if (this.colours !== "none") {
      const value = this.colouredValues()[index], sign = this.colours === "along" && value > 0 ? "+" : "";
      lines.push(this.colours === "uncertainty" ? `sd ${shown(value)} ${unit}` : `${sign}${shown(value)} ${unit} from ${this.reference === MEAN ? "the mean" : this.model.names[this.reference]}`);
    }
    setText(element("tip"), lines.join("\n"));
  }

  // ------------------------------------------------------------------ the mouse

  /** The landmark that CSS pixels of the canvas show, or -1: one that is fixed there, else the nearest of the face in front. */
  landmarkAt(pixel) {
    const { size } = this.renderer;
    const near = (point, within) => {
      const [x, y] = this.camera.project(point, size);
      return Math.hypot(x - pixel[0], y - pixel[1]) < within;
    };
    for (const [index, target] of this.fixed) if (this.sees(index) && near(target, 9)) return index;
    if (this.model.faces.length) {
      const found = pickedLandmark(this.shape, this.model.faces, this.camera.ray(pixel, size), (index) => this.sees(index));
      return found ? found.index : -1;
    }
    for (let index = 0; index < this.model.landmarks; ++index) if (this.sees(index) && near(this.place(index), 7)) return index;
    return -1;
  }

  hover(pixel) {
    const index = pixel ? this.landmarkAt(pixel) : -1, tip = element("tip");
    tip.hidden = index < 0;
    if (index >= 0) {
      this.describe(index);
      const { width } = this.renderer.size;
      tip.style.left = `${Math.min(pixel[0] + 16, width - tip.offsetWidth - 4)}px`;
      tip.style.top = `${Math.max(pixel[1] - tip.offsetHeight - 12, 4)}px`;
    }
    if (index !== this.hovered) {
      this.hovered = index;
      this.drawOverlay();
    }
  }

  followMouse() {
    const canvas = element("surface");
    let drag = null;
    const pixelOf = (event) => [event.offsetX, event.offsetY];
    const fixes = (event) => event.button === 0 && (event.shiftKey || document.querySelector("[name=tool]:checked").value === "fix");
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      const pixel = pixelOf(event), index = this.landmarkAt(pixel), isFixed = this.fixed.has(index);
      drag = { pixel, kind: event.button === 0 ? "turn" : "pan" };
      if (index >= 0 && (fixes(event) || (isFixed && event.button === 0))) {
        this.stop();
        const place = this.fixed.get(index) || this.place(index), [x, y, front] = this.camera.project(place, this.renderer.size);
        this.hover(null);
        drag = { kind: "fix", index, front, offset: [x - pixel[0], y - pixel[1]] }; // it does not jump to the mouse
      }
      canvas.classList.toggle("turning", drag.kind !== "fix");
    });
    canvas.addEventListener("pointermove", (event) => {
      const pixel = pixelOf(event);
      if (!drag) {
        this.hover(pixel);
        canvas.classList.toggle("fixing", this.hovered >= 0 && (fixes({ button: 0, shiftKey: event.shiftKey }) || this.fixed.has(this.hovered)));
        return;
      }
      if (drag.kind === "fix") {
        const at = [pixel[0] + drag.offset[0], pixel[1] + drag.offset[1]];
        this.fixRelative(drag.index, this.camera.unproject(at, drag.front, this.renderer.size));
        return;
      }
      const [right, down] = [pixel[0] - drag.pixel[0], pixel[1] - drag.pixel[1]];
      drag.pixel = pixel;
      if (drag.kind === "turn") this.camera.rotate(0.008 * right, 0.008 * down);
      else this.camera.pan(right, down, this.renderer.size.height);
      this.hover(null);
      this.changed();
    });
    const end = () => {
      drag = null;
      canvas.classList.remove("turning");
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("pointerleave", () => this.hover(null));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(0.0012 * event.deltaY));
      this.changed();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
      const zooms = { "+": 0.9, "=": 0.9, "-": 1 / 0.9 };
      if (turns[event.key]) this.camera.rotate(...turns[event.key]);
      else if (zooms[event.key]) this.camera.zoom(zooms[event.key]);
      else if (event.key === "0") this.camera.reset();
      else return;
      event.preventDefault();
      this.changed();
    });
    new ResizeObserver(() => this.changed()).observe(canvas);
  }

  // ------------------------------------------------------------------ the side of the page

  setUp() {
    const { data, model } = this, count = model.names.length;
    element("title").textContent = data.title;
    element("about").textContent = data.about;
    const choices = () => [made("option", { value: MEAN, textContent: "Mean" }), ...model.names.map((name, k) => made("option", { value: k, textContent: name }))];
    const which = (value) => (value === MEAN ? MEAN : Number(value));
    element("shapes").append(...choices(), made("option", { value: "own", textContent: "scores of your own", disabled: true }));
    element("shapes").onchange = (event) => [this.stop(), this.show(which(event.target.value))];
    element("reference").append(...choices());
    element("reference").onchange = (event) => this.setColours(this.colours, which(event.target.value));
    element("colours").onchange = (event) => this.setColours(event.target.value, this.reference);
    element("previous").onclick = () => this.step(-1);
    element("next").onclick = () => this.step(1);
    element("play").onclick = () => this.play();
    element("play").title = `Through the ${data.noun}s in their order`;
    element("player").hidden = count < 2 || !model.modes;
    element("time").max = Math.max(count - 1, 0);
    element("time").oninput = (event) => [this.stop(), this.show(Number(event.target.value))];
    element("cycle").checked = data.cyclic;
    element("modes").hidden = element("fixing").hidden = !model.modes;
    for (const name of model.modes ? [] : ["uncertainty"]) element("colours").querySelector(`[value=${name}]`).disabled = true;
    element("mean").onclick = () => [this.stop(), this.fixed.clear(), this.fit()];
    this.rows = data.shares.map((share, m) => this.row(m, share));
    element("sliders").append(...this.rows.map((row) => row.line));

    element("noise").value = Number(this.noise.toPrecision(3));
    element("noise-unit").textContent = data.unit;
    element("noise").onchange = (event) => this.setNoise(Number(event.target.value));
    element("index").max = this.number(model.landmarks - 1);
    element("fix").onclick = () => {
      const index = this.numbered(Number(element("index").value));
      if (index >= 0 && Number.isInteger(index)) this.fixRelative(index, this.place(index));
    };
    element("again").onclick = () => [this.stop(), this.fit()];
    element("unfix").onclick = () => this.release();
    element("front").onclick = () => [this.camera.reset(), this.changed()];
    element("dots").onchange = () => this.changed();
    element("parts").hidden = this.visible.length < 2;
    element("parts").append(
      ...this.visible.map((_, part) =>
        made("label", { className: "check" }, [
          made("input", { type: "checkbox", checked: true, onchange: (event) => this.showPart(part, event.target.checked) }),
          data.partNames[part],
        ]),
      ),
    );
    this.followMouse();
  }

  showPart(part, shows) {
    this.visible[part] = shows;
    this.changed();
  }

  row(m, share) {
    const slider = made("input", { type: "range", min: -REACH, max: REACH, step: 0.01, value: 0, ariaLabel: `Mode ${m + 1}` });
    const play = made("button", { textContent: "▶", ariaLabel: `Play mode ${m + 1}`, ariaPressed: "false", onclick: () => this.play(m) });
    const output = made("output", { textContent: "0.00" });
    slider.oninput = () => [this.stop(), this.setMode(m, Number(slider.value))];
    slider.ondblclick = () => [this.stop(), this.setMode(m, 0)];
    slider.onkeydown = (event) => {
      const by = { ArrowLeft: -0.1, ArrowDown: -0.1, ArrowRight: 0.1, ArrowUp: 0.1, PageDown: -1, PageUp: 1 }[event.key];
      if (!by) return;
      event.preventDefault();
      this.stop();
      this.setMode(m, Math.max(-REACH, Math.min(REACH, Math.round(100 * (this.scores[m] + by)) / 100)));
    };
    const line = made("div", { className: "mode" }, [
      play,
      made("span", { className: "number", textContent: m + 1 }),
      made("span", { className: "share", textContent: `${shown(100 * share, share < 0.1 ? 2 : 1)} %`, title: "Share of the variance" }),
      slider,
      output,
    ]);
    return { slider, play, output, line, told: 0 };
  }
}

function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

function complain(words) {
  element("error").textContent = words;
  element("error").hidden = false;
}

/** What scripts may call; positions are in the model's own coordinates. */
function interfaceOf(page) {
  const { model } = page;
  return {
    landmarks: model.landmarks,
    modes: model.modes,
    names: model.names,
    scores: () => Array.from(page.scores),
    setScores: (scores) => page.setScores(Float64Array.from({ length: model.modes }, (_, m) => scores[m] || 0)),
    setMode: (mode, deviations) => page.setMode(mode, deviations),
    show: (shape) => page.show(shape),
    play: (mode) => page.play(mode),
    stop: () => page.stop(),
    mahalanobis: () => mahalanobis(page.scores),
    vertices: () => {
      const shape = model.shape(page.scores);
      return Array.from({ length: model.landmarks }, (_, j) => model.centre.map((value, axis) => value + shape[3 * j + axis]));
    },
    fix: (index, target) => page.fix(index, target),
    release: (index) => page.release(index),
    fixed: () => Array.from(page.fixed, ([index, target]) => ({ index, target: target.map((value, axis) => value + model.centre[axis]) })),
    noise: () => page.noise,
    setNoise: (noise) => page.setNoise(noise),
    uncertainty: () => Array.from(model.uncertainty(page.factor)),
    setColours: (colours, reference = MEAN) => page.setColours(colours, reference),
    colours: () => Array.from(page.colours === "none" ? [] : [page.update(), page.colouredValues()][1]),
    landmarkAt: (x, y) => page.landmarkAt([x, y]),
    pixelOf: (index) => page.camera.project(Array.from(model.shape(page.scores).subarray(3 * index, 3 * index + 3)), page.renderer.size),
    turn: (right, down) => [page.camera.rotate(right, down), page.changed()],
    /** Mean milliseconds that a picture takes: in all, and without drawing it. */
    measure: (count = 50) => {
      const { draw } = page.renderer, scores = Array.from(page.scores);
      const timed = (finish) => {
        const start = performance.now();
        for (let i = 0; i < count; ++i) {
          page.setScores(page.scores.map((_, m) => Math.sin(i + m)));
          page.update();
          finish();
        }
        return (performance.now() - start) / count;
      };
      timed(() => page.renderer.finish());
      const whole = timed(() => page.renderer.finish());
      page.renderer.draw = () => {};
      const without = timed(() => {});
      page.renderer.draw = draw;
      page.setScores(scores);
      return { whole, without };
    },
  };
}

try {
  window.explorer = interfaceOf(new Explorer(JSON.parse(element("data").textContent)));
} catch (error) {
  complain(error.message);
  throw error;
}
