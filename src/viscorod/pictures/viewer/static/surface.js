"use strict";
/* The surfaces of all rods as one mesh: rings of vertices along the centre lines, moved and coloured in every frame. */

viscorod.Surface = class {
  constructor(meta, arrays) {
    this.meta = meta;
    this.arrays = arrays;
    this.nodes = arrays.positions.row / 3;
    this.rings = arrays.ring_first.shape[0];
    this.nodeAt = new Float32Array(3 * this.nodes);
    this.nodeTurn = new Float32Array(4 * this.nodes);
    this.at = new Float32Array(3 * this.rings);
    this.turn = new Float32Array(4 * this.rings);
    this.value = new Float32Array(this.rings);
    this.halves = new Float32Array(arrays.halves.values);
    this.unknown = 0.006 * meta.look.size; // radius where no section is known
    let ring = 0;
    for (const line of meta.lines) {
      if (!line.known) this.halves.fill(this.unknown, 2 * ring, 2 * (ring + line.rings));
      ring += line.rings;
    }
    this.factor = 1;
    this.build();
    this.field = null;
  }

  /* Corners of a polygon, twice each: once for the side before and once for the one after. */
  sides(corners) {
    const n = corners.length;
    const normals = corners.map(([x, y], k) => {
      const [u, v] = corners[(k + 1) % n];
      const size = Math.hypot(u - x, v - y) || 1;
      return [(v - y) / size, (x - u) / size];
    });
    return corners.flatMap(([x, y], k) => [(k + n - 1) % n, k].map((side) => ({ x, y, normal: normals[side], flat: true })));
  }

  /* Regions of a section, each the corners of its outer rim, then of its holes, in which the walls are. A hole that is
     scaled from the outer rim has another size on every ring. Corners of holes are clockwise: their walls look inward. */
  regions({ outline, contours }, hollow) {
    if (contours.length) return contours.map((region) => region.map((rim) => ({ corners: this.sides(rim), scaled: false })));
    const box = [[1, 1], [-1, 1], [-1, -1], [1, -1]];
    const outer = outline === "box" ? this.sides(box) : this.circle();
    const inward = ({ x, y, normal: [u, v], flat }) => ({ x, y, normal: [-u, -v], flat });
    const inner = outline === "box" ? this.sides(box.reverse()) : this.circle().reverse().map(inward);
    return [[{ corners: outer, scaled: false }, ...(hollow ? [{ corners: inner, scaled: true }] : [])]];
  }

  circle() {
    return Array.from({ length: 14 }, (_, k) => {
      const angle = (2 * Math.PI * k) / 14;
      return { x: Math.cos(angle), y: Math.sin(angle), normal: [Math.cos(angle), Math.sin(angle)], flat: false };
    });
  }

  /* Triangles between the rims of a region, numbered through. */
  cap([outer, ...holes]) {
    const n = outer.length;
    if (!holes.length || !holes[0][0].scaled) {
      const points = [outer, ...holes].map((rim) => rim.map(({ x, y }) => new THREE.Vector2(x, y)));
      return THREE.ShapeUtils.triangulateShape(points[0], points.slice(1));
    }
    return outer.flatMap((_, k) => {
      const next = (k + 1) % n;
      const [inside, beside] = [2 * n - 1 - k, 2 * n - 1 - next]; // the hole runs the other way round
      return [[k, next, beside], [k, beside, inside]];
    });
  }

  build() {
    const index = [];
    this.parts = [];
    let vertex = 0;
    let ring = 0;
    for (const line of this.meta.lines) {
      const hollow = this.arrays.holes.values.subarray(ring, ring + line.rings).some((part) => part > 0);
      for (const region of this.regions(line, hollow)) {
        const rims = region.map(({ corners, scaled }) => {
          const n = corners.length;
          const start = vertex;
          for (let r = 0; r + 1 < line.rings; r++) {
            for (let j = 0; j < n; j++) {
              if (corners[j].flat && j % 2 === 0) continue; // the two vertices of one corner
              const next = (j + 1) % n;
              const [a, b] = [start + r * n + j, start + r * n + next];
              index.push(a, b, a + n, b, b + n, a + n);
            }
          }
          vertex += (line.rings + 2) * n; // and once more at both ends
          this.parts.push({ corners, scaled, ring, rings: line.rings, start });
          const kept = corners.map((_, k) => k).filter((k) => !corners[k].flat || k % 2 === 0);
          return kept.map((k) => ({ x: corners[k].x, y: corners[k].y, scaled, ends: [start + line.rings * n + k, start + (line.rings + 1) * n + k] }));
        });
        const at = rims.flat();
        for (const [a, b, c] of this.cap(rims)) {
          index.push(at[a].ends[0], at[c].ends[0], at[b].ends[0], at[a].ends[1], at[b].ends[1], at[c].ends[1]);
        }
      }
      ring += line.rings;
    }
    this.geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal", "color"]) {
      this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * vertex), 3));
    }
    this.geometry.setIndex(index);
    const material = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide });
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
  }

  /* Centre lines at a frame; the weights are those of the elements' polynomials. */
  move(k, part) {
    viscorod.between(this.arrays.positions, k, part, this.nodeAt);
    viscorod.between(this.arrays.rotations, k, part, this.nodeTurn, true);
    this.along(this.nodeAt, 3, this.at);
    this.along(this.nodeTurn, 4, this.turn);
    for (let r = 0; r < 4 * this.rings; r += 4) {
      const size = Math.hypot(this.turn[r], this.turn[r + 1], this.turn[r + 2], this.turn[r + 3]) || 1;
      for (let i = 0; i < 4; i++) this.turn[r + i] /= size;
    }
  }

  along(values, c, out) {
    const weights = this.arrays.ring_weights.values;
    const width = this.arrays.ring_weights.shape[1];
    const first = this.arrays.ring_first.values;
    for (let r = 0; r < this.rings; r++) {
      for (let i = 0; i < c; i++) {
        let sum = 0;
        for (let w = 0; w < width; w++) {
          const weight = weights[r * width + w];
          if (weight !== 0) sum += weight * values[(first[r] + w) * c + i];
        }
        out[r * c + i] = sum;
      }
    }
    return out;
  }

  /* Vertices from centre lines, turned sections and colours of the rings. */
  draw(colourOf) {
    const position = this.geometry.attributes.position.array;
    const normal = this.geometry.attributes.normal.array;
    const colour = this.geometry.attributes.color.array;
    const { at, turn, halves, factor } = this;
    const holes = this.arrays.holes.values;
    for (const { corners, scaled, ring, rings, start } of this.parts) {
      const n = corners.length;
      for (let k = 0; k < rings + 2; k++) {
        const cap = k >= rings;
        const r = ring + (cap ? (k === rings ? 0 : rings - 1) : k);
        const [w, x, y, z] = [turn[4 * r], turn[4 * r + 1], turn[4 * r + 2], turn[4 * r + 3]];
        const d1 = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
        const d2 = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)];
        const d3 = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
        const part = factor * (scaled ? holes[r] : 1);
        const [a, b] = [part * halves[2 * r], part * halves[2 * r + 1]];
        const shade = colourOf(this.value[r]);
        for (let j = 0; j < n; j++) {
          const o = corners[j];
          const v = 3 * (start + k * n + j);
          let [nx, ny] = o.normal;
          if (!o.flat) [nx, ny] = [nx * b, ny * a];
          const size = Math.hypot(nx, ny) || 1;
          for (let i = 0; i < 3; i++) {
            position[v + i] = at[3 * r + i] + a * o.x * d1[i] + b * o.y * d2[i];
            normal[v + i] = cap ? (k === rings ? -d3[i] : d3[i]) : (nx * d1[i] + ny * d2[i]) / size;
            colour[v + i] = shade[i];
          }
        }
      }
    }
    for (const name of ["position", "normal", "color"]) this.geometry.attributes[name].needsUpdate = true;
  }
};

/* Fields that can be shown: those stored, and sizes made of two of them. */
viscorod.fields = function (meta, arrays) {
  const stored = Object.fromEntries(meta.fields.map((field) => [field.key, { ...field, array: arrays[`field_${field.key}`] }]));
  const fields = [];
  const size = (key, title, one, two, scaleBy) => {
    if (!stored[one] || !stored[two]) return;
    const { unit, scale } = scaleBy ? { unit: "%", scale: 100 } : stored[one].scale < stored[two].scale ? stored[one] : stored[two];
    fields.push({ key, title, unit, scale, at: "points", arrays: [stored[one].array, stored[two].array], times: scaleBy });
  };
  const widths = arrays.point_half_width && arrays.point_half_width.values;
  if (widths && widths.some((width) => width > 0)) size("fibre", "bending strain of the outer fibre", "strain3", "strain4", widths);
  size("bending", "bending curvature", "strain3", "strain4", null);
  size("moment", "bending moment", "force3", "force4", null);
  for (const key of ["dissipation", "speed", ...Object.keys(stored)]) {
    const field = stored[key];
    if (field && !fields.some((other) => other.key === key)) fields.push({ ...field, arrays: [field.array] });
  }
  return fields;
};

viscorod.FieldReader = class {
  constructor(surface, meta, arrays) {
    this.surface = surface;
    this.scratch = [];
    this.ranges = new Map();
    this.nodeS = arrays.node_s.values;
    if (!arrays.point_s) return;
    [this.pointS, this.line] = [arrays.point_s.values, arrays.point_line.values];
    const [s, line] = [arrays.point_s.values, arrays.point_line.values];
    const rings = surface.rings;
    this.lower = new Uint32Array(rings);
    this.upper = new Uint32Array(rings);
    this.part = new Float32Array(rings);
    let ring = 0;
    meta.lines.forEach((rod, number) => {
      const mine = [];
      for (let k = 0; k < s.length; k++) if (line[k] === number) mine.push(k);
      for (let r = ring; r < ring + rod.rings && mine.length; r++) {
        const x = arrays.ring_s.values[r];
        let k = 0;
        while (k + 2 < mine.length && s[mine[k + 1]] < x) k++;
        const [a, b] = [mine[k], mine[Math.min(k + 1, mine.length - 1)]];
        this.lower[r] = a;
        this.upper[r] = b;
        // beyond the outermost points their values hold
        this.part[r] = b === a ? 0 : Math.min(Math.max((x - s[a]) / (s[b] - s[a]), 0), 1);
      }
      ring += rod.rings;
    });
  }

  /* First and last (not counted) number of a rod's values of a field, and their arc lengths. */
  along(field, number) {
    const { lines } = this.surface.meta;
    if (field.at === "nodes") {
      const from = lines.slice(0, number).reduce((sum, { nodes }) => sum + nodes, 0);
      const to = from + lines[number].nodes;
      return [from, to, Array.from(this.nodeS.subarray(from, to))];
    }
    const from = this.line.indexOf(number);
    const to = this.line.lastIndexOf(number) + 1;
    return [Math.max(from, 0), to, Array.from(this.pointS.subarray(Math.max(from, 0), to))];
  }

  at(field, k, part) {
    const row = field.arrays[0].row;
    const out = new Float32Array(row);
    viscorod.between(field.arrays[0], k, part, out);
    if (field.arrays.length > 1) {
      const other = viscorod.between(field.arrays[1], k, part, new Float32Array(row));
      for (let j = 0; j < row; j++) out[j] = Math.hypot(out[j], other[j]) * (field.times ? field.times[j] : 1);
    }
    for (let j = 0; j < row; j++) out[j] *= field.scale;
    return out;
  }

  rings(field, k, part) {
    const values = this.at(field, k, part);
    const out = this.surface.value;
    if (field.at === "nodes") this.surface.along(values, 1, out);
    else for (let r = 0; r < out.length; r++) out[r] = (1 - this.part[r]) * values[this.lower[r]] + this.part[r] * values[this.upper[r]];
    return values;
  }

  /* Smallest and largest value over the whole run. */
  range(field) {
    if (!this.ranges.has(field.key)) {
      let [low, high] = [Infinity, -Infinity];
      if (field.arrays.length === 1) {
        const { whole, low: from, step } = field.arrays[0];
        let [least, most] = [65535, 0];
        for (let k = 0; k < whole.length; k++) {
          if (whole[k] < least) least = whole[k];
          if (whole[k] > most) most = whole[k];
        }
        [low, high] = [(from[0] + step[0] * least) * field.scale, (from[0] + step[0] * most) * field.scale];
      } else {
        for (let k = 0; k < field.arrays[0].shape[0]; k++) {
          for (const value of this.at(field, k, 0)) {
            if (value < low) low = value;
            if (value > high) high = value;
          }
        }
      }
      this.ranges.set(field.key, [low, high]);
    }
    return this.ranges.get(field.key);
  }
};
