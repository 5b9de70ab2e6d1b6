"use strict";
/* The view in space: camera, light, grid, trace, names; draws when something has changed. */

viscorod.Space = class {
  constructor(meta, arrays, canvas) {
    this.meta = meta;
    this.arrays = arrays;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    const { look } = meta;
    this.camera = new THREE.PerspectiveCamera(28, 1, look.size * 1e-3, look.size * 100);
    this.camera.up.fromArray(look.up);
    this.target = new THREE.Vector3(...look.centre);
    this.camera.position.copy(this.target).addScaledVector(new THREE.Vector3(...look.eye), 3 * look.size);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.target.copy(this.target);
    this.controls.addEventListener("change", () => this.refresh());
    const light = new THREE.DirectionalLight("#ffffff", 1.6);
    light.position.set(0.4, 0.7, 1);
    this.camera.add(light);
    this.scene.add(this.camera, new THREE.AmbientLight("#ffffff", 1.9));

    this.surface = new viscorod.Surface(meta, arrays);
    this.reader = new viscorod.FieldReader(this.surface, meta, arrays);
    this.symbols = new viscorod.Symbols(meta, arrays, look.size);
    this.scene.add(this.surface.mesh, this.symbols.parts, this.symbols.loads);
    this.reference = this.referenceLines();
    this.ghosts = this.ghostLines();
    this.grid = new THREE.Group();
    this.scene.add(this.reference, this.ghosts, this.grid);
    this.dress();
    this.trace = new THREE.Group();
    this.scene.add(this.trace);
    this.names = this.nameTags();
    this.showNames = true;
    this.tables = Object.fromEntries(
      Object.entries(meta.colours).map(([key, table]) => [key, table.map((rgb) => new THREE.Color().setRGB(...rgb.map((v) => v / 255), THREE.SRGBColorSpace).toArray())]),
    );
    this.frame = [0, 0];
    this.field = null;
    this.rangeNow = false;
    this.onRange = () => {};
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
    this.fit();
  }

  referenceLines() {
    const group = new THREE.Group();
    const at = this.surface.along(this.arrays.reference.values, 3, new Float32Array(3 * this.surface.rings));
    let ring = 0;
    for (const line of this.meta.lines) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(at.slice(3 * ring, 3 * (ring + line.rings)), 3));
      const size = 0.012 * this.meta.look.size;
      const dashes = viscorod.painted(new THREE.LineDashedMaterial({ dashSize: size, gapSize: 0.7 * size }), viscorod.COLOUR.reference);
      const curve = new THREE.Line(geometry, dashes);
      curve.computeLineDistances();
      group.add(curve);
      ring += line.rings;
    }
    return group;
  }

  gridBelow() {
    const { low, high, centre, up, cell, size } = this.meta.look;
    const reach = Math.max(...high.map((value, k) => (Math.abs(up[k]) > 0.5 ? 0 : value - low[k])), 0.3 * size);
    const cells = 2 * Math.ceil((1.1 * reach) / (2 * cell));
    const grid = new THREE.GridHelper(cells * cell, cells, viscorod.style("--edge"), viscorod.style("--faint"));
    grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...up));
    grid.position.fromArray(
      centre.map((value, k) => {
        if (Math.abs(up[k]) < 0.5) return cell * Math.round(value / cell);
        return up[k] > 0 ? low[k] - 0.04 * size : high[k] + 0.04 * size;
      }),
    );
    return grid;
  }

  /* Take the colours of the page, which is light or dark. */
  dress() {
    this.renderer.setClearColor(viscorod.style("--page"));
    this.scene.traverse(({ material }) => {
      if (material?.userData?.colour) viscorod.painted(material, material.userData.colour);
    });
    if (!this.field) this.colour();
    this.grid.clear();
    this.grid.add(this.gridBelow());
    this.refresh();
  }

  /* The rods of other results, as lines. */
  ghostLines() {
    const group = new THREE.Group();
    for (const [k, { array, counts }] of this.meta.ghosts.entries()) {
      let first = 0;
      for (const count of counts) {
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
        const line = new THREE.Line(geometry, viscorod.painted(new THREE.LineBasicMaterial(), viscorod.GHOSTS[k % 3]));
        line.frustumCulled = false;
        line.userData = { array: this.arrays[array], first };
        group.add(line);
        first += count;
      }
    }
    return group;
  }

  moveGhosts(k, part) {
    let last = null;
    for (const line of this.ghosts.children) {
      const { array, first } = line.userData;
      if (!last || last.array !== array) last = { array, at: viscorod.between(array, k, part, new Float32Array(array.row)) };
      const place = line.geometry.attributes.position;
      place.array.set(last.at.subarray(3 * first, 3 * (first + place.count)));
      place.needsUpdate = true;
    }
  }

  /* What is seen, with its names and a line of text, as a picture. */
  picture(text) {
    this.renderer.render(this.scene, this.camera);
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const paper = document.createElement("canvas");
    [paper.width, paper.height] = [this.canvas.width, this.canvas.height + Math.round(26 * ratio)];
    const pen = paper.getContext("2d");
    pen.fillStyle = viscorod.style("--page");
    pen.fillRect(0, 0, paper.width, paper.height);
    pen.drawImage(this.canvas, 0, 0);
    pen.scale(ratio, ratio);
    const write = (words, x, y, colour, font) => {
      pen.font = font;
      pen.fillStyle = colour;
      pen.fillText(words, x, y);
    };
    const font = '12.5px system-ui, "DejaVu Sans", sans-serif';
    pen.textBaseline = "top";
    for (const { tag } of this.names) {
      if (tag.hidden) continue;
      const [x, y] = tag.style.transform.match(/-?[\d.]+/g).map(Number);
      write(tag.textContent, x + 3, y + 2, getComputedStyle(tag).color, font);
    }
    const foot = this.canvas.clientHeight;
    const triad = document.getElementById("triad");
    for (const part of triad.children) {
      const at = (name) => 0.84 * Number(part.getAttribute(name) || 0);
      if (part.tagName === "text") {
        write(part.textContent, 46 + at("x") - 4, foot - 46 + at("y") - 7, getComputedStyle(part).fill, font);
        continue;
      }
      pen.strokeStyle = getComputedStyle(part).stroke;
      pen.lineWidth = 2;
      pen.beginPath();
      pen.moveTo(46, foot - 46);
      pen.lineTo(46 + at("x2"), foot - 46 + at("y2"));
      pen.stroke();
    }
    const legend = this.field ? `${this.field.title}: ${document.getElementById("scale-low").textContent} to ${document.getElementById("scale-high").textContent}` : "";
    write([text, legend].filter(Boolean).join("; "), 8, foot + 5, viscorod.style("--ink"), font);
    return new Promise((done) => { paper.toBlob(done); });
  }

  nameTags() {
    const box = document.getElementById("labels");
    return this.symbols.names.slice(0, 24).map((name) => {
      const tag = document.createElement("span");
      tag.style.color = `var(${name.colour})`;
      box.append(tag);
      return { ...name, tag };
    });
  }

  /* All that a place passes through; what it has passed stands out. */
  leaveTrace(mark) {
    for (const line of this.trace.children) line.geometry.dispose();
    this.trace.clear();
    if (mark === null) return this.refresh();
    const { marks } = this.arrays;
    const count = marks.shape[0];
    const points = new Float32Array(3 * count);
    const row = new Float32Array(marks.row);
    for (let k = 0; k < count; k++) points.set(viscorod.between(marks, k, 0, row).subarray(3 * mark, 3 * mark + 3), 3 * k);
    for (const colour of [viscorod.COLOUR.coming, viscorod.COLOUR.trace]) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
      const line = new THREE.Line(geometry, viscorod.painted(new THREE.LineBasicMaterial(), colour));
      line.frustumCulled = false;
      line.renderOrder = colour === viscorod.COLOUR.trace ? 2 : 1;
      this.trace.add(line);
    }
    return this.refresh();
  }

  show(k, part) {
    this.frame = [k, part];
    this.changed = true;
    this.refresh();
  }

  refresh() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
    });
  }

  draw() {
    const [k, part] = this.frame;
    if (this.changed) {
      this.changed = false;
      this.surface.move(k, part);
      this.symbols.move(k, part);
      this.moveGhosts(k, part);
      this.colour();
      if (this.trace.children.length) this.trace.children[1].geometry.setDrawRange(0, k + 1);
    }
    this.renderer.render(this.scene, this.camera);
    this.placeNames();
    this.drawTriad();
  }

  colour() {
    if (!this.field) {
      const plain = new THREE.Color(viscorod.style("--rod")).toArray();
      this.surface.draw(() => plain);
      return;
    }
    const values = this.reader.rings(this.field, ...this.frame);
    let [low, high] = this.reader.range(this.field);
    const signed = low < -1e-3 * Math.abs(high);
    if (this.rangeNow) [low, high] = values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    if (signed) [low, high] = [-Math.max(-low, high), Math.max(-low, high)];
    else if (!this.rangeNow) low = Math.min(low, 0);
    const table = this.tables[signed ? "signed" : "plain"];
    const span = high - low;
    const scale = span > 0 ? (table.length - 1) / span : 0;
    const middle = table[signed ? table.length >> 1 : 0];
    this.surface.draw((value) => (scale ? table[Math.max(0, Math.min(table.length - 1, Math.round((value - low) * scale)))] : middle));
    this.onRange(low, high, signed);
  }

  placeNames() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const taken = this.furniture();
    const point = new THREE.Vector3();
    for (const { tag, text, mark, point: fixed, of } of this.names) {
      const words = this.showNames && this.symbols[of].visible ? text() : "";
      if (mark === undefined) point.copy(fixed);
      else this.symbols.point(mark, point);
      point.project(this.camera);
      const [x, y] = [(0.5 + 0.5 * point.x) * width + 9, (0.5 - 0.5 * point.y) * height + 7];
      if (!words || Math.abs(point.z) > 1 || x < 0 || y < 0 || x > width || y > height) {
        tag.hidden = true;
        continue;
      }
      if (tag.textContent !== words) tag.textContent = words;
      tag.hidden = false;
      const wide = tag.offsetWidth;
      let [left, top] = [Math.max(2, Math.min(x, width - wide - 2)), Math.min(y, height - 20)];
      const meets = (t) => left < t[0] + t[2] && t[0] < left + wide && top < t[1] + t[3] + 1 && t[1] < top + 17;
      for (let tries = 0; tries < 12 && taken.some(meets); tries++) top += 17;
      taken.push([left, top, wide, 16]);
      tag.style.transform = `translate(${left}px, ${top}px)`;
    }
  }

  /* Boxes of the buttons and of what stands in the legend: left, top, width, height in the view. */
  furniture() {
    const view = this.canvas.getBoundingClientRect();
    return [...document.querySelectorAll("#look button, #legend span")].map((part) => {
      const box = part.getBoundingClientRect();
      return [box.left - view.left, box.top - view.top, box.width, box.height];
    });
  }

  drawTriad() {
    const triad = document.getElementById("triad");
    const turn = this.camera.quaternion.clone().invert();
    const axes = ["x", "y", "z"].map((name, k) => {
      const axis = new THREE.Vector3(...[0, 1, 2].map((i) => Number(i === k))).applyQuaternion(turn);
      return { name, axis };
    });
    axes.sort((a, b) => a.axis.z - b.axis.z);
    if (!triad.children.length) {
      for (const { name } of axes) {
        for (const kind of ["line", "text"]) {
          const element = document.createElementNS("http://www.w3.org/2000/svg", kind);
          element.dataset.axis = name;
          triad.append(element);
        }
      }
    }
    for (const { name, axis } of axes) {
      const [line, text] = triad.querySelectorAll(`[data-axis="${name}"]`);
      const colour = `var(--name-${name})`;
      line.setAttribute("x2", 34 * axis.x);
      line.setAttribute("y2", -34 * axis.y);
      line.setAttribute("stroke", colour);
      line.setAttribute("stroke-width", 2.5);
      text.setAttribute("x", 44 * axis.x);
      text.setAttribute("y", -44 * axis.y);
      text.setAttribute("fill", colour);
      text.textContent = name;
      triad.append(line, text);
    }
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    if (!box.width || !box.height) return;
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    this.refresh();
  }

  /* Put the eye so far away, in the direction in which it is, that everything is in the picture. */
  fit(direction = null) {
    const { low, high, centre, up } = this.meta.look;
    const target = new THREE.Vector3(...centre);
    const back = direction ? direction.clone() : this.camera.position.clone().sub(this.controls.target).normalize();
    if (Math.abs(back.dot(new THREE.Vector3(...up))) > 0.999) back.addScaledVector(new THREE.Vector3(up[1], up[2], up[0]), -1e-3).normalize();
    const right = new THREE.Vector3(...up).cross(back).normalize();
    const above = back.clone().cross(right);
    const tan = Math.tan((this.camera.fov * Math.PI) / 360);
    let distance = 0.1 * this.meta.look.size;
    for (let corner = 0; corner < 8; corner++) {
      const point = new THREE.Vector3(...[0, 1, 2].map((k) => (corner & (1 << k) ? high[k] : low[k]))).sub(target);
      const near = point.dot(back);
      distance = Math.max(distance, near + Math.abs(point.dot(right)) / (tan * this.camera.aspect), near + Math.abs(point.dot(above)) / tan);
    }
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(back, 1.22 * distance);
    this.controls.update();
    this.refresh();
  }

  look(word) {
    const directions = { first: this.meta.look.eye, x: [1, 0, 0], y: [0, -1, 0], z: [0, 0, 1] };
    this.fit(word in directions ? new THREE.Vector3(...directions[word]) : null);
  }
};
