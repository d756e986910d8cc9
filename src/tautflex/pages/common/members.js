// Beams and cables as thin tubes, supports as small cones, drawn many at once.

import * as THREE from "three";
import { drawnBySoftware } from "page/software";

const SIDES = drawnBySoftware ? 4 : 6; // of a tube
const UP = new THREE.Vector3(0, 1, 0);
const from = new THREE.Vector3();
const to = new THREE.Vector3();
const along = new THREE.Vector3();
const turn = new THREE.Quaternion();
const size = new THREE.Vector3();
const place = new THREE.Matrix4();

export class Tubes {
  constructor(lines, radius, colour) {
    this.lines = lines;
    this.radius = radius;
    this.count = lines.length / 2;
    const shape = new THREE.CylinderGeometry(1, 1, 1, SIDES, 1, true);
    this.mesh = new THREE.InstancedMesh(shape, new THREE.MeshLambertMaterial({ color: colour }), this.count);
    this.mesh.frustumCulled = false;
  }

  // Moves every tube between its nodes, whose places are x, y, z in a row.
  move(points) {
    for (let k = 0; k < this.count; k++) {
      from.fromArray(points, 3 * this.lines[2 * k]);
      to.fromArray(points, 3 * this.lines[2 * k + 1]);
      along.subVectors(to, from);
      const length = along.length();
      turn.setFromUnitVectors(UP, along.divideScalar(length || 1));
      place.compose(from.add(to).multiplyScalar(0.5), turn, size.set(this.radius, length, this.radius));
      this.mesh.setMatrixAt(k, place);
    }
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  // One colour for all, or colours r, g, b in a row.
  paint(colours, plain) {
    const colour = new THREE.Color();
    this.mesh.material.color.set(colours ? "#ffffff" : plain);
    for (let k = 0; k < this.count; k++) {
      if (colours) colour.setRGB(colours[3 * k] / 255, colours[3 * k + 1] / 255, colours[3 * k + 2] / 255, THREE.SRGBColorSpace);
      else colour.set("#ffffff");
      this.mesh.setColorAt(k, colour);
    }
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }
}

export class Supports {
  constructor(nodes, points, length) {
    const shape = new THREE.ConeGeometry(0.6 * length, length, 4);
    shape.rotateX(Math.PI / 2);
    shape.translate(0, 0, -0.5 * length);
    this.mesh = new THREE.InstancedMesh(shape, new THREE.MeshLambertMaterial(), nodes.length);
    this.mesh.frustumCulled = false;
    nodes.forEach((node, k) => {
      place.makeTranslation(points[3 * node], points[3 * node + 1], points[3 * node + 2]);
      this.mesh.setMatrixAt(k, place);
    });
  }
}
