//! Fills triangles into a depth buffer, shades them, and paints floor and background where nothing stands.

use super::camera::Camera;
use super::shadow::Shadow;
use nalgebra::Vector3;

/// Pixels are averaged over so many samples in each direction.
const SAMPLES: usize = 2;

/// Background, red, green, blue.
const BACKGROUND: [f64; 3] = [1.0, 1.0, 1.0];

/// Floor and its lines near the middle; both fade into the background.
const FLOOR: [f64; 3] = [0.925, 0.935, 0.95];
const LINE: [f64; 3] = [0.80, 0.82, 0.85];

/// Distance between the lines of the floor [m], and their half width [m].
const SPACING: f64 = 0.5;
const HALF_WIDTH: f64 = 0.004;

/// A coloured triangle in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub places: [Vector3<f64>; 3],
    pub normals: [Vector3<f64>; 3],
    pub color: [f64; 3],
}

/// A picture, three bytes per pixel, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    pub width: usize,
    pub height: usize,
    pub rgb: Vec<u8>,
}

/// The floor that is seen.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    /// Its z [m].
    pub height: f64,
    /// Around here it is strongest.
    pub center: Vector3<f64>,
    /// At this distance it has faded [m].
    pub reach: f64,
}

/// Paints the faces over the ground.
pub(crate) fn paint(
    faces: &[Face],
    ground: &Ground,
    camera: &Camera,
    shadow: &Shadow,
    height: usize,
) -> Picture {
    let size = [
        (height as f64 * camera.aspect).round() as usize * SAMPLES,
        height * SAMPLES,
    ];
    let mut depth = vec![f64::INFINITY; size[0] * size[1]];
    let mut color = vec![[0.0f64; 3]; size[0] * size[1]];
    for face in faces {
        fill(face, camera, shadow, size, &mut depth, &mut color);
    }
    for (i, color) in color.iter_mut().enumerate() {
        if depth[i].is_infinite() {
            let pixel = [(i % size[0]) as f64 + 0.5, (i / size[0]) as f64 + 0.5];
            *color = floor(&camera.ray(pixel, size), ground, camera, shadow);
        }
    }
    average(&color, size)
}

fn fill(
    face: &Face,
    camera: &Camera,
    shadow: &Shadow,
    size: [usize; 2],
    depth: &mut [f64],
    color: &mut [[f64; 3]],
) {
    let [Some(a), Some(b), Some(c)] = face.places.map(|place| camera.project(&place, size)) else {
        return;
    };
    let inverse = [a, b, c].map(|corner| 1.0 / corner[2]);
    cover(
        [a, b, c].map(|corner| [corner[0], corner[1]]),
        size,
        |x, y, weights| {
            // 1/depth and x/depth are linear in the picture.
            let one_over: f64 = (0..3).map(|k| weights[k] * inverse[k]).sum();
            let here = 1.0 / one_over;
            let at = y * size[0] + x;
            if here < depth[at] {
                depth[at] = here;
                let share = [0, 1, 2].map(|k| weights[k] * inverse[k] * here);
                let mix =
                    |of: &[Vector3<f64>; 3]| of[0] * share[0] + of[1] * share[1] + of[2] * share[2];
                color[at] = shade(
                    face.color,
                    &mix(&face.normals).normalize(),
                    &mix(&face.places),
                    camera,
                    shadow,
                );
            }
        },
    );
}

/// Calls `pixel` with the barycentric weights for all pixels whose middle a triangle covers.
pub(crate) fn cover(
    [a, b, c]: [[f64; 2]; 3],
    size: [usize; 2],
    mut pixel: impl FnMut(usize, usize, [f64; 3]),
) {
    let cross = |o: [f64; 2], p: [f64; 2], q: [f64; 2]| {
        (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])
    };
    let area = cross(a, b, c);
    if area.abs() < 1e-12 {
        return;
    }
    let range = |k: usize| {
        let low = a[k].min(b[k]).min(c[k]).floor().max(0.0) as usize;
        let high = (a[k].max(b[k]).max(c[k]).ceil().max(0.0) as usize).min(size[k]);
        low..high
    };
    for y in range(1) {
        for x in range(0) {
            let p = [x as f64 + 0.5, y as f64 + 0.5];
            let weights = [cross(p, b, c), cross(p, c, a), cross(p, a, b)].map(|w| w / area);
            if weights.iter().all(|w| *w >= 0.0) {
                pixel(x, y, weights);
            }
        }
    }
}

/// Light from the sky, more from above, and from the lamp where it reaches.
fn shade(
    color: [f64; 3],
    normal: &Vector3<f64>,
    place: &Vector3<f64>,
    camera: &Camera,
    shadow: &Shadow,
) -> [f64; 3] {
    let to_eye = (camera.eye - place).normalize();
    let normal = if normal.dot(&to_eye) < 0.0 {
        -normal
    } else {
        *normal
    };
    let facing = normal.dot(&shadow.towards).max(0.0);
    let lamp = if facing > 0.0 {
        facing * shadow.light(&(place + normal * 0.006))
    } else {
        0.0
    };
    let sky = 0.42 + 0.16 * normal.z;
    let half = (shadow.towards + to_eye).normalize();
    let gloss = 0.10 * lamp * normal.dot(&half).max(0.0).powi(24);
    color.map(|c| to_display(to_light(c) * (sky + 0.72 * lamp) + gloss))
}

fn to_light(c: f64) -> f64 {
    c.powf(2.2)
}

fn to_display(c: f64) -> f64 {
    c.clamp(0.0, 1.0).powf(1.0 / 2.2)
}

fn floor(ray: &Vector3<f64>, ground: &Ground, camera: &Camera, shadow: &Shadow) -> [f64; 3] {
    let distance = (ground.height - camera.eye.z) / ray.z;
    if !(distance > 0.0 && distance.is_finite()) {
        return BACKGROUND;
    }
    let place = camera.eye + ray * distance;
    let off = (place - ground.center).xy().norm() / ground.reach;
    if off >= 1.0 {
        return BACKGROUND;
    }
    let near_line = |x: f64| ((x / SPACING).round() * SPACING - x).abs() < HALF_WIDTH;
    let base = if near_line(place.x) || near_line(place.y) {
        LINE
    } else {
        FLOOR
    };
    let light = 0.72 + 0.28 * shadow.light(&place);
    let keep = (1.0 - off * off).powi(2);
    [0, 1, 2].map(|k| keep * base[k] * light + (1.0 - keep) * BACKGROUND[k])
}

fn average(color: &[[f64; 3]], size: [usize; 2]) -> Picture {
    let [width, height] = size.map(|n| n / SAMPLES);
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            for k in 0..3 {
                let sum: f64 = (0..SAMPLES * SAMPLES)
                    .map(|i| {
                        color[(y * SAMPLES + i / SAMPLES) * size[0] + x * SAMPLES + i % SAMPLES][k]
                    })
                    .sum();
                rgb.push((255.0 * sum / (SAMPLES * SAMPLES) as f64).round() as u8);
            }
        }
    }
    Picture { width, height, rgb }
}
