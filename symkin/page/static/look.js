// Colours and materials of the drawing, light and dark.
import * as THREE from "three";

export class Look {
  constructor(colours) {
    this.colours = colours; // by theme: {light: {key: "#rrggbb"}, dark}
    this.dark = false;
    this.materials = new Map();
    this.outline = outlineMaterial();
  }

  /** The colour of a key of the palette, or of a "#rrggbb" of its own. */
  colour(key) {
    if (!key.startsWith("#")) return this.colours[this.dark ? "dark" : "light"][key];
    return this.dark ? `#${new THREE.Color(key).lerp(new THREE.Color("#ffffff"), 0.12).getHexString()}` : key;
  }

  solid(key) {
    return this._kept(`solid ${key}`, key, () => new THREE.MeshLambertMaterial());
  }

  glass(key) {
    const settings = { transparent: true, opacity: 0.22, side: THREE.DoubleSide, depthWrite: false };
    return this._kept(`glass ${key}`, key, () => new THREE.MeshBasicMaterial(settings));
  }

  /** Half transparent, so that joints and lines within are seen. */
  shell(key) {
    const settings = { transparent: true, opacity: 0.55, side: THREE.DoubleSide };
    return this._kept(`shell ${key}`, key, () => new THREE.MeshLambertMaterial(settings));
  }

  line(key) {
    return this._kept(`line ${key}`, key, () => new THREE.LineBasicMaterial());
  }

  /** Lines behind everything else. */
  backdrop(key) {
    return this._kept(`backdrop ${key}`, key, () => new THREE.LineBasicMaterial({ depthTest: false, depthWrite: false }));
  }

  dashes(key, length) {
    return this._kept(`dashes ${key} ${length}`, key, () => new THREE.LineDashedMaterial({ dashSize: length, gapSize: 0.7 * length }));
  }

  setDark(dark) {
    this.dark = dark;
    for (const { material, key } of this.materials.values()) material.color.set(this.colour(key));
    this.outline.uniforms.colour.value.set(this.colour("outline"));
  }

  /** Contours of a width, in pixels of a picture of so many. */
  setContours(across, up, width = 1.25) {
    this.outline.uniforms.pixels.value.set(across, up);
    this.outline.uniforms.width.value = width;
  }

  _kept(name, key, make) {
    if (!this.materials.has(name)) {
      const material = make();
      material.color.set(this.colour(key));
      this.materials.set(name, { material, key });
    }
    return this.materials.get(name).material;
  }
}

/** Draws the back of a shell a little larger than its solid, so that every solid has a contour of the same width in pixels. */
function outlineMaterial() {
  return new THREE.ShaderMaterial({
    side: THREE.BackSide,
    uniforms: {
      colour: { value: new THREE.Color() },
      pixels: { value: new THREE.Vector2(1, 1) },
      width: { value: 1.25 },
    },
    vertexShader: `uniform vec2 pixels; uniform float width;
      void main() {
        vec4 place = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        vec2 way = (projectionMatrix * vec4(normalize(normalMatrix * normal), 0.0)).xy * pixels;
        float length_ = length(way);
        if (length_ > 1e-6) place.xy += way / length_ * width * 2.0 / pixels * place.w;
        gl_Position = place;
      }`,
    fragmentShader: `uniform vec3 colour; void main() { gl_FragColor = vec4(colour, 1.0);\n#include <colorspace_fragment>\n }`,
  });
}
