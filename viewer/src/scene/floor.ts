// The ground: a grid that fades out, and a surface that only shows shadows.

import * as THREE from "three";

const VERTEX = `
varying vec2 place;
void main() { place = (modelMatrix * vec4(position, 1.0)).xy; gl_Position = projectionMatrix * viewMatrix * modelMatrix * vec4(position, 1.0); }`;

const FRAGMENT = `
varying vec2 place;
uniform vec3 color;
uniform vec2 center;
uniform float reach;
float lines(float spacing, float width) {
  vec2 at = place / spacing;
  vec2 size = fwidth(at);
  vec2 near = abs(fract(at - 0.5) - 0.5) / size;
  vec2 line = 1.0 - clamp(near - width, 0.0, 1.0);
  return max(line.x, line.y) * clamp(1.5 - 3.0 * max(size.x, size.y), 0.0, 1.0);
}
void main() {
  float fade = 1.0 - smoothstep(0.25, 1.0, length(place - center) / reach);
  float alpha = max(0.14 * lines(0.25, 0.0), 0.42 * lines(1.0, 0.3)) * fade;
  gl_FragColor = vec4(color, alpha);
}`;

export class Floor {
  readonly root = new THREE.Group();
  private readonly grid: THREE.ShaderMaterial;
  private readonly shadow: THREE.ShadowMaterial;

  constructor(height: number, center: THREE.Vector3, reach: number) {
    this.grid = new THREE.ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false,
      uniforms: { color: { value: new THREE.Color() }, center: { value: new THREE.Vector2(center.x, center.y) }, reach: { value: reach } },
    });
    this.shadow = new THREE.ShadowMaterial({ opacity: 0.22 });
    for (const [surface, lift] of [[this.grid, 0.0008], [this.shadow, 0.0004]] as const) {
      const mesh = new THREE.Mesh(new THREE.PlaneGeometry(2 * reach, 2 * reach), surface);
      mesh.position.set(center.x, center.y, height + lift);
      mesh.receiveShadow = surface === this.shadow;
      mesh.renderOrder = -1;
      this.root.add(mesh);
    }
  }

  setTheme(line: string, shadow: number): void {
    (this.grid.uniforms.color.value as THREE.Color).set(line);
    this.shadow.opacity = shadow;
  }
}
