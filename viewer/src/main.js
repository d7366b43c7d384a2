// The viewer of a report: its controls stand in the page, and this file connects them with the picture.
import { Vector3 } from "three";
import { Picture } from "./picture.js";

const STEP = 0.12; // rad for a press of an arrow key
const KEYS = { ArrowLeft: [-STEP, 0, 1], ArrowRight: [STEP, 0, 1], ArrowUp: [0, STEP, 1], ArrowDown: [0, -STEP, 1], "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1.1] };
const AXES = { x: new Vector3(1, 0, 0), y: new Vector3(0, -1, 0), z: new Vector3(0, 0, 1) };

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function start(root) {
  const find = (selector) => root.querySelector(selector);
  if (!document.createElement("canvas").getContext("webgl2")) return; // the pictures in the page remain
  const data = JSON.parse(find("script").textContent);
  if (data.cells) data.cells.classes = await unpacked(data.cells.classes);
  root.hidden = false;
  const picture = new Picture(find(".stage"), data);
  const { canvas, controls } = picture;
  const buttons = [...root.querySelectorAll("button")];
  const [cut, slider, shown, words] = ["select", "input", "output", ".shown"].map(find);
  let pose = data.poses[0];

  // The plane of the cut: its normal points to the viewer. "arm" is the plane through the base's axis and the tool.
  function normal() {
    if (cut.value !== "arm") return AXES[cut.value];
    const azimuth = Math.atan2(pose.tool[1], pose.tool[0]);
    return new Vector3(Math.sin(azimuth), -Math.cos(azimuth), 0);
  }
  function moved() {
    const facing = normal();
    const sign = cut.value === "y" ? -1 : 1;
    if (picture.cells) picture.cells.group.visible = cut.value !== "none";
    if (facing) {
      picture.cells?.cut(facing, sign * slider.value * 1e-3);
      shown.value = `${Math.round(slider.value)}\u202fmm`.replace("-", "−");
    } else picture.cells?.cut(null);
    picture.paint();
  }
  // Put the plane through the arm, or across the middle of the workspace, and look at it from the side that is cut away.
  function faced() {
    const facing = normal();
    slider.disabled = !facing;
    shown.value = "";
    if (facing && picture.cells) {
      const sign = cut.value === "y" ? -1 : 1;
      const ends = picture.cells.extent(facing).map((end) => sign * end * 1e3).sort((a, b) => a - b);
      const first = cut.value === "arm" ? 0 : Math.round((ends[0] + ends[1]) / 2);
      slider.min = first - Math.ceil((first - ends[0]) / slider.step) * slider.step; // steps count from here, so the first place is one of them
      slider.max = Math.ceil(ends[1]);
      slider.value = first;
    }
    moved();
    looked();
  }
  function looked() {
    const facing = normal() ?? AXES.y;
    const direction = facing.clone().applyAxisAngle(AXES.z, 0.42);
    if (facing.z) direction.set(0.35, -0.75, 1.1);
    else direction.z = 0.33;
    picture.look(direction.normalize());
    picture.paint();
  }
  function posed(k) {
    pose = data.poses[k];
    buttons.forEach((each, i) => each.setAttribute("aria-pressed", i === k));
    words.textContent = pose.words;
    picture.pose(pose);
  }
  function themed() {
    picture.theme();
    picture.pose(pose);
    picture.paint();
  }

  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", root.dataset.label);
  canvas.addEventListener("focus", () => (controls.enableZoom = true)); // otherwise nobody could scroll past the picture
  canvas.addEventListener("blur", () => (controls.enableZoom = false));
  canvas.addEventListener("keydown", (event) => {
    if (event.key === "0" || event.key === "Home") looked();
    else if (KEYS[event.key]) picture.turn(...KEYS[event.key]);
    else return;
    event.preventDefault();
  });
  buttons.forEach((each, k) =>
    each.addEventListener("click", () => {
      posed(k);
      if (normal()) faced();
      else picture.paint();
    }),
  );
  cut.addEventListener("change", faced);
  slider.addEventListener("input", moved);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", themed);

  if (!picture.cells) find(".cut").hidden = true;
  document.documentElement.classList.add("viewed");
  picture.theme();
  picture.resize();
  posed(0);
  faced();
  picture.draw();
  root.dataset.drawn = "yes";
}

document.querySelectorAll(".viewer").forEach(start);
