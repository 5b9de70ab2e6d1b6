"use strict";
/* Supports, bodies, joints, springs and loads: groups that follow their marks. */

/* Names of colours of the page, which is light or dark. */
viscorod.GHOSTS = ["--ghost-0", "--ghost-1", "--ghost-2"];
viscorod.COLOUR = { support: "--ink", body: "--body", joint: "--joint", spring: "--spring", load: "--load", trace: "--trace", coming: "--coming", reference: "--reference" };

/* Give a material a colour of the page, which it keeps when that becomes light or dark. */
viscorod.painted = function (material, name) {
  material.userData.colour = name;
  material.color.set(viscorod.style(name));
  return material;
};

viscorod.Symbols = class {
  constructor(meta, arrays, size) {
    this.meta = meta;
    this.arrays = arrays;
    this.size = size;
    this.at = new Float32Array(arrays.marks.row);
    this.turn = new Float32Array(arrays.turns.row);
    this.parts = new THREE.Group();
    this.loads = new THREE.Group();
    this.followers = [];
    this.names = []; // { text(), mark or point, colour, of: "parts" | "loads" }
    this.kinds = new Map();
    for (const support of meta.scene.supports) this.support(support);
    for (const body of meta.scene.bodies) this.body(body);
    for (const connection of meta.scene.connections) this.connection(connection);
    meta.scene.loads.forEach((load, k) => this.load(load, k));
  }

  material(colour, opacity = 1) {
    return viscorod.painted(new THREE.MeshLambertMaterial({ transparent: opacity < 1, opacity, depthWrite: opacity === 1 }), colour);
  }

  point(mark, out = new THREE.Vector3()) {
    return out.fromArray(this.at, 3 * mark);
  }

  quaternion(mark, out = new THREE.Quaternion()) {
    const [w, x, y, z] = this.turn.slice(4 * mark, 4 * mark + 4);
    return out.set(x, y, z, w).normalize();
  }

  follow(object, mark, turns = true) {
    this.parts.add(object);
    this.followers.push(() => {
      this.point(mark, object.position);
      if (turns) this.quaternion(mark, object.quaternion);
    });
  }

  support({ kind, label, mark }) {
    const size = 0.028 * this.size;
    const material = this.material(viscorod.COLOUR.support);
    const plate = Math.max(1.5 * size, 2.4 * this.arrays.halves.values.reduce((a, b) => Math.max(a, b), 0)); // seen around the rod
    const body = this.meta.scene.bodies.some((other) => other.mark === mark);
    if (kind === "pin" || kind === "roller" || kind === "guide" || kind === "support") {
      const cone = new THREE.Mesh(new THREE.ConeGeometry(0.6 * size, size, 4, 1).translate(0, -0.5 * size, 0), material);
      cone.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...this.meta.look.up));
      this.follow(cone, mark, false);
    } else if (!body) {
      this.follow(new THREE.Mesh(new THREE.BoxGeometry(plate, plate, 0.35 * size), material), mark);
    }
    if (body) this.held = (this.held || new Set()).add(mark);
    this.kinds.set(`support`, ["supports", viscorod.COLOUR.support]);
    this.names.push({ text: () => label, mark, colour: viscorod.COLOUR.support, of: "parts" });
  }

  body({ label, mark, fixed, shape, size, turn }) {
    const held = this.held && this.held.has(mark);
    const small = 0.016 * this.size;
    const material = this.material(held ? viscorod.COLOUR.support : viscorod.COLOUR.body, shape === "point" ? 1 : 0.6);
    const geometry = {
      box: () => new THREE.BoxGeometry(...size),
      sphere: () => new THREE.SphereGeometry(size[0], 32, 20),
      cylinder: () => new THREE.CylinderGeometry(size[0], size[0], size[1], 40).rotateX(Math.PI / 2),
      point: () => new THREE.OctahedronGeometry(small),
    }[shape]();
    const mesh = new THREE.Mesh(geometry, material);
    const [w, x, y, z] = turn;
    mesh.quaternion.set(x, y, z, w);
    const group = new THREE.Group();
    group.add(mesh);
    this.follow(group, mark);
    for (const other of fixed) this.line([mark, other], held ? viscorod.COLOUR.support : viscorod.COLOUR.body);
    this.kinds.set("body", [this.meta.scene.bodies.length > 1 ? "bodies" : "body", viscorod.COLOUR.body]);
    if (!held) this.names.push({ text: () => label, mark, colour: "--name-body", of: "parts" });
  }

  line(marks, colour) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * marks.length), 3));
    const line = new THREE.Line(geometry, viscorod.painted(new THREE.LineBasicMaterial(), colour));
    line.frustumCulled = false;
    this.parts.add(line);
    this.followers.push(() => {
      const values = geometry.attributes.position.array;
      marks.forEach((mark, k) => values.set(this.at.subarray(3 * mark, 3 * mark + 3), 3 * k));
      geometry.attributes.position.needsUpdate = true;
    });
  }

  connection({ kind, label, marks, axes }) {
    const colour = kind === "joint" ? viscorod.COLOUR.joint : viscorod.COLOUR.spring;
    if (kind === "joint") {
      this.follow(new THREE.Mesh(new THREE.SphereGeometry(0.011 * this.size, 20, 14), this.material(colour)), marks[1], false);
      this.line(marks, colour);
      for (const axis of axes) {
        const length = 0.09 * this.size;
        const stick = new THREE.Mesh(new THREE.CylinderGeometry(0.0025 * this.size, 0.0025 * this.size, length, 8), this.material(colour));
        this.parts.add(stick);
        this.followers.push(() => {
          this.point(marks[1], stick.position);
          stick.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), this.point(axis).normalize());
        });
      }
    } else {
      this.spring(marks, colour);
    }
    this.kinds.set(kind, [kind === "joint" ? "joints" : "springs", colour]);
    this.names.push({ text: () => label, mark: marks[1], colour: `--name-${kind}`, of: "parts" });
  }

  /* A coil between two marks, as wide as it is legible. */
  spring(marks, colour) {
    const count = 181;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    const line = new THREE.Line(geometry, viscorod.painted(new THREE.LineBasicMaterial(), colour));
    line.frustumCulled = false;
    this.parts.add(line);
    const turn = new THREE.Quaternion();
    this.followers.push(() => {
      const [a, b] = marks.map((mark) => this.point(mark));
      const along = b.clone().sub(a);
      const length = along.length();
      const radius = Math.min(0.01 * this.size, 0.2 * length);
      turn.setFromUnitVectors(new THREE.Vector3(0, 0, 1), length ? along.clone().divideScalar(length) : new THREE.Vector3(0, 0, 1));
      for (let k = 0; k < count; k++) {
        const part = k / (count - 1);
        const wide = radius * Math.min(1, Math.max(0, Math.min(part - 0.12, 0.88 - part) / 0.05));
        const point = new THREE.Vector3(wide * Math.cos(50 * part), wide * Math.sin(50 * part), part * length).applyQuaternion(turn).add(a);
        point.toArray(geometry.attributes.position.array, 3 * k);
      }
      geometry.attributes.position.needsUpdate = true;
    });
  }

  arrow(turning) {
    const group = new THREE.Group();
    const material = this.material(viscorod.COLOUR.load);
    const size = this.size;
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.0035 * size, 0.0035 * size, 1, 10).translate(0, 0.5, 0), material);
    const heads = (turning ? [0, 1] : [0]).map(() => new THREE.Mesh(new THREE.ConeGeometry(0.011 * size, 0.03 * size, 16).translate(0, -0.015 * size, 0), material));
    group.add(shaft, ...heads);
    group.userData.stretch = (length) => {
      shaft.scale.y = Math.max(length - 0.02 * size, 1e-6);
      heads.forEach((head, k) => { head.position.y = length - 0.032 * k * size; });
    };
    this.loads.add(group);
    return group;
  }

  load({ kind, label, unit, family, scale, turning, feet, arrows, largest }, number) {
    const gravity = kind === "gravity";
    const most = Math.max(...this.meta.scene.loads.filter((other) => other.family === family).map((other) => other.largest));
    const sizes = this.arrays.load_sizes;
    const corner = new THREE.Vector3(...this.meta.look.low.map((low, k) => (this.meta.look.up[k] > 0.5 ? this.meta.look.high[k] : low)));
    const up = new THREE.Vector3(0, 1, 0);
    const tip = new THREE.Vector3();
    let now = 0;
    const groups = arrows.map(() => this.arrow(turning));
    this.followers.push((k, part) => {
      const count = sizes.shape[1];
      const last = sizes.shape[0] - 1;
      const [from, to] = [sizes.values[Math.min(k, last) * count + number], sizes.values[Math.min(k + 1, last) * count + number]];
      now = part > 0 && (from === 0 || to === 0) ? from : from + part * (to - from); // a load that is let go jumps
      groups.forEach((group, j) => {
        const vector = this.point(arrows[j]);
        const size = vector.length();
        group.visible = now > 1e-9 * largest && size > 0.02;
        if (!group.visible) return;
        const length = (gravity ? 0.12 : 0.05 + 0.13 * Math.sqrt(Math.min((size * largest) / most, 1))) * this.size;
        group.quaternion.setFromUnitVectors(up, vector.divideScalar(size));
        if (gravity) group.position.copy(corner);
        else this.point(feet[j], group.position);
        group.userData.stretch(length);
        if (j === Math.floor(groups.length / 2)) tip.copy(group.position).addScaledVector(vector, length);
      });
    });
    this.kinds.set("load", ["loads", viscorod.COLOUR.load]);
    const text = () => (now > 1e-9 * largest ? `${label}: ${viscorod.text(now * scale, 3)} ${unit}` : "");
    this.names.push({ text, point: tip, colour: "--name-load", of: "loads" });
  }

  move(k, part) {
    viscorod.between(this.arrays.marks, k, part, this.at);
    viscorod.between(this.arrays.turns, k, part, this.turn, true);
    for (const follow of this.followers) follow(k, part);
  }
};
