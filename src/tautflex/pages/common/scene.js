// A structure in three dimensions.

import * as THREE from "three";
import { OrbitControls } from "three/orbit";
import { colourOf, ink, rising, twoSided } from "page/colours";
import { Supports, Tubes } from "page/members";
import { Sharpness } from "page/sharpness";
import { drawnBySoftware } from "page/software";

const HOME = new THREE.Vector3(0.42, -0.8, 0.62).normalize();
const LABELS = ["x", "y", "z"];
const NONE = new THREE.Quaternion();

export class Stage {
  // mesh: places of the nodes and numbers of what is drawn between them; name: written over it, if any.
  constructor(mesh, holder, name) {
    this.mesh = mesh;
    this.holder = holder;
    this.points = Float32Array.from(mesh.nodes);
    this.values = new Float32Array(this.points.length / 3);
    this.marks = [];
    this.renderer = new THREE.WebGLRenderer({ antialias: !drawnBySoftware, alpha: true, preserveDrawingBuffer: true });
    this.sharpness = new Sharpness();
    this.sharpen(false);
    holder.append(this.renderer.domElement);
    if (name) holder.append(Object.assign(document.createElement("div"), { className: "name", textContent: name }));
    this.said = holder.appendChild(Object.assign(document.createElement("div"), { className: "said" }));
    this.scene = new THREE.Scene();
    this.body = new THREE.Group();
    this.scene.add(this.body);
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.build();
    this.dress();
  }

  build() {
    const { mesh } = this;
    const { span } = mesh;
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8d97a5", 2.1));
    const lamp = new THREE.DirectionalLight("#ffffff", 1.3);
    lamp.position.set(1, -2, 3);
    this.scene.add(lamp);
    this.buildFilm(mesh);
    this.cables = new Tubes(mesh.cables, 0.0016 * span, "#888888");
    this.links = new Tubes(mesh.links, 0.003 * span, "#888888");
    this.beams = new Tubes(mesh.beams, 0.0055 * span, "#444444");
    this.supports = new Supports(mesh.held, mesh.nodes, 0.028 * span);
    this.body.add(this.cables.mesh, this.links.mesh, this.beams.mesh, this.supports.mesh);
    // Where the structure stood at first, to see it turn and bend against.
    const outline = mesh.beams.length ? mesh.beams : rim(mesh.triangles);
    const ends = new Float32Array(3 * outline.length);
    outline.forEach((node, k) => ends.set(mesh.nodes.subarray(3 * node, 3 * node + 3), 3 * k));
    const shape = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(ends, 3));
    this.reference = new THREE.LineSegments(shape, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.7 }));
    this.scene.add(this.reference);
    this.axes = LABELS.map((label, k) => {
      const end = new THREE.Vector3().setComponent(k, 0.16 * span);
      const line = new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), end]);
      this.mark(label, `var(--axis-${label})`, () => end.clone());
      const axis = new THREE.Line(line, new THREE.LineBasicMaterial());
      this.body.add(axis);
      return axis;
    });
    const probes = mesh.probes || { names: [], nodes: [] };
    this.dots = probes.nodes.map((node, k) => {
      const dot = new THREE.Mesh(new THREE.SphereGeometry(0.008 * span, 12, 8), new THREE.MeshLambertMaterial());
      this.body.add(dot);
      this.mark(probes.names[k], "", () => new THREE.Vector3().fromArray(this.points, 3 * node));
      return [dot, node];
    });
    this.box = new THREE.Box3().setFromArray(mesh.nodes);
  }

  buildFilm(mesh) {
    const corners = mesh.triangles.length;
    this.film = new THREE.BufferGeometry();
    const attribute = (kind, normalised) => new THREE.BufferAttribute(new kind(3 * corners), 3, normalised);
    this.film.setAttribute("position", attribute(Float32Array, false));
    this.film.setAttribute("normal", attribute(Float32Array, false));
    this.film.setAttribute("color", attribute(Float32Array, false));
    const look = { vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    this.body.add(this.unculled(new THREE.Mesh(this.film, new THREE.MeshLambertMaterial(look))));
    this.net = new THREE.BufferGeometry();
    this.net.setAttribute("position", new THREE.BufferAttribute(this.points, 3));
    this.net.setIndex([...mesh.edges]);
    this.netLines = this.unculled(new THREE.LineSegments(this.net, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.22 })));
    this.netLines.visible = false;
    this.body.add(this.netLines);
    this.normals = new Float32Array(this.points.length);
  }

  unculled(object) {
    object.frustumCulled = false;
    return object;
  }

  mark(text, colour, where) {
    const label = this.holder.appendChild(Object.assign(document.createElement("div"), { className: "mark", textContent: text }));
    if (colour) label.style.color = colour;
    this.marks.push([label, where]);
  }

  // Colours that follow the page's light or dark look.
  dress() {
    this.beams.paint(null, ink("--beam"));
    this.links.paint(null, ink("--cable"));
    this.supports.mesh.material.color.set(ink("--support"));
    this.reference.material.color.set(ink("--reference"));
    this.netLines.material.color.set(ink("--ink"));
    this.axes.forEach((axis, k) => axis.material.color.set(ink(`--axis-${LABELS[k]}`)));
    for (const [dot] of this.dots) dot.material.color.set(ink("--ink"));
  }

  // Draws with all of the screen's pixels where nothing moves, with fewer where frames are late.
  sharpen(moving) {
    if (!moving) this.sharpness.rest();
    const part = moving ? this.sharpness.moving(performance.now()) : 1;
    if (part === this.part) return;
    this.part = part;
    this.renderer.setPixelRatio(part * Math.min(window.devicePixelRatio, 2));
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    [this.width, this.height] = [width, height];
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  // Camera so far away that the structure's box stays in the picture at all these attitudes, with room for its motion.
  home(turns, room) {
    const corners = boxCorners(this.box, Math.max(room, 0.04 * this.mesh.span)); // supports stand out, too
    const places = turns.flatMap((turn) => corners.map((corner) => corner.clone().applyQuaternion(turn)));
    const target = new THREE.Box3().setFromPoints(places).getCenter(new THREE.Vector3());
    this.camera.position.copy(target).add(HOME);
    this.camera.lookAt(target);
    this.camera.updateMatrix();
    const [right, up, back] = [0, 1, 2].map((k) => new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, k));
    const tall = Math.tan((this.camera.fov * Math.PI) / 360);
    const needed = places.map((place) => {
      place.sub(target);
      const across = Math.max(Math.abs(place.dot(right)) / (tall * this.camera.aspect), Math.abs(place.dot(up)) / tall);
      return 1.06 * across + place.dot(back);
    });
    const distance = Math.max(...needed, this.mesh.span);
    this.controls.target.copy(target);
    this.camera.position.copy(HOME).multiplyScalar(distance).add(target);
    this.camera.near = 0.02 * distance;
    this.camera.far = 20 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  // Turns the structure; where it stood at first stays, or turns by another.
  turn(now, first) {
    this.body.quaternion.copy(now);
    this.reference.quaternion.copy(first || NONE);
  }

  // Paints the film: a corner's colour is an entry of a table.
  paintFilm(table, placeOf) {
    const { triangles } = this.mesh;
    const colours = this.film.getAttribute("color").array;
    for (let k = 0; k < triangles.length; k++) {
      const place = 3 * placeOf(k);
      for (let c = 0; c < 3; c++) colours[3 * k + c] = LINEAR[table[place + c]];
    }
    this.film.getAttribute("color").needsUpdate = true;
  }

  // Paints the film by its displacement w within a limit, and where it pushes, if that is known.
  paintDisplacement(limit, film) {
    const { triangles } = this.mesh;
    const pushes = film && film.least < 0 ? (k) => film.pushes[film.triangle[Math.floor(k / 3)]] : () => 0;
    this.paintFilm(twoSided.table, (k) => (pushes(k) ? twoSided.beyond : colourOf(this.values[triangles[k]], -limit, limit)));
  }

  // Paints the cables by tensions within limits.
  paintCables(tensions, [low, high]) {
    const own = new Uint8Array(3 * tensions.length);
    tensions.forEach((tension, k) => {
      const place = 3 * colourOf(tension, low, high);
      own.set(rising.table.subarray(place, place + 3), 3 * k);
    });
    this.cables.paint(own);
  }

  draw() {
    this.place();
    this.body.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    const { width, height } = this;
    for (const [label, where] of this.marks) {
      const at = where().applyMatrix4(this.body.matrixWorld).project(this.camera);
      label.style.transform = `translate(${(0.5 * at.x + 0.5) * width + 6}px, ${(0.5 - 0.5 * at.y) * height - 18}px)`;
      label.hidden = Math.abs(at.x) > 0.98 || Math.abs(at.y) > 0.98;
    }
  }

  // Film, tubes and dots follow the points; a node's normal is the sum of those of its triangles.
  place() {
    const { triangles } = this.mesh;
    const { points, normals } = this;
    normals.fill(0);
    for (let k = 0; k < triangles.length; k += 3) {
      const a = 3 * triangles[k];
      const b = 3 * triangles[k + 1];
      const c = 3 * triangles[k + 2];
      const ux = points[b] - points[a];
      const uy = points[b + 1] - points[a + 1];
      const uz = points[b + 2] - points[a + 2];
      const vx = points[c] - points[a];
      const vy = points[c + 1] - points[a + 1];
      const vz = points[c + 2] - points[a + 2];
      for (let corner = 0; corner < 3; corner++) {
        const node = 3 * triangles[k + corner];
        normals[node] += uy * vz - uz * vy;
        normals[node + 1] += uz * vx - ux * vz;
        normals[node + 2] += ux * vy - uy * vx;
      }
    }
    const places = this.film.getAttribute("position");
    const directions = this.film.getAttribute("normal");
    for (let k = 0; k < triangles.length; k++) {
      const node = 3 * triangles[k];
      for (let c = 0; c < 3; c++) {
        places.array[3 * k + c] = points[node + c];
        directions.array[3 * k + c] = normals[node + c]; // the shader makes it one long
      }
    }
    places.needsUpdate = directions.needsUpdate = true;
    this.net.getAttribute("position").needsUpdate = true;
    for (const tubes of [this.cables, this.links, this.beams]) tubes.move(points);
    for (const [dot, node] of this.dots) dot.position.fromArray(points, 3 * node);
  }
}

function boxCorners({ min, max }, room) {
  const found = [];
  for (const x of [min.x, max.x]) {
    for (const y of [min.y, max.y]) for (const z of [min.z - room, max.z + room]) found.push(new THREE.Vector3(x, y, z));
  }
  return found;
}

// Edges of one triangle only: nodes, two of each.
function rim(triangles) {
  const found = new Map();
  for (let k = 0; k < triangles.length; k++) {
    const pair = [triangles[k], triangles[k % 3 === 2 ? k - 2 : k + 1]];
    const name = `${Math.min(...pair)} ${Math.max(...pair)}`;
    found.set(name, found.has(name) ? [] : pair);
  }
  return [...found.values()].flat();
}

// Colours of vertices are linear in light.
const LINEAR = Float32Array.from({ length: 256 }, (_, k) => new THREE.Color().setRGB(k / 255, 0, 0, THREE.SRGBColorSpace).r);
