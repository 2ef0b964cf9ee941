//! Normalises the scene to unit size, chooses the view, and projects.

use crate::drawing::Drawing;
use crate::options::{Projection, RenderOptions, UpAxis};
use crate::scene::Scene;
use eikona_mesh::vector::{Vec3, add, cross, dot, norm, scale, sub, unit};

/// Distance of the near plane, in units of the scene's radius.
pub(crate) const NEAR: f64 = 1e-4;

/// Margin on each side, as a fraction of the image.
const MARGIN: f64 = 0.05;

/// Maps coordinates of any magnitude to a box about the origin with half diagonal 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normalization {
    largest: f64,
    center: Vec3,
    radius: f64,
}

impl Normalization {
    pub(crate) fn of(scene: &Scene) -> Normalization {
        let drawn = scene.drawings.iter().flat_map(Drawing::positions);
        let vertices = scene.mesh.triangles().iter().flatten().map(|&v| &scene.mesh.positions()[v as usize]);
        let all = || vertices.clone().chain(drawn.clone());
        let largest = all().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        // Divide by the largest coordinate first: differences of huge numbers would overflow,
        // squares of tiny ones underflow.
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in all() {
            for k in 0..3 {
                low[k] = low[k].min(p[k] / largest);
                high[k] = high[k].max(p[k] / largest);
            }
        }
        if low[0] > high[0] {
            return Normalization { largest, center: [0.0; 3], radius: 1.0 };
        }
        let radius = norm(sub(high, low)) / 2.0;
        let center = scale(add(low, high), 0.5);
        Normalization { largest, center, radius: if radius > 0.0 { radius } else { 1.0 } }
    }
    pub(crate) fn apply(&self, p: Vec3) -> Vec3 {
        [0, 1, 2].map(|k| (p[k] / self.largest - self.center[k]) / self.radius)
    }
    fn length(&self, x: f64) -> f64 {
        x / self.largest / self.radius
    }
}

/// Point in homogeneous sample coordinates `(X, Y, W)`, at sample `(X / W, Y / W)`, with its
/// distance in front of the camera.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Projected {
    pub(crate) h: Vec3,
    pub(crate) depth: f64,
}

/// Camera with fitted position and focal length.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) perspective: bool,
    pub(crate) eye: Vec3,
    pub(crate) right: Vec3,
    pub(crate) up: Vec3,
    /// From the scene to the camera.
    pub(crate) back: Vec3,
    /// Samples per unit at distance 1 (perspective) or per unit (orthographic).
    pub(crate) focal: f64,
    pub(crate) center: [f64; 2],
    /// Up direction of the scene, and whether there is a ground.
    pub(crate) world_up: Vec3,
    pub(crate) has_ground: bool,
}

impl View {
    pub(crate) fn project(&self, p: Vec3) -> Projected {
        let q = sub(p, self.eye);
        let depth = -dot(q, self.back);
        let w = if self.perspective { depth } else { 1.0 };
        let x = self.focal * dot(q, self.right) + self.center[0] * w;
        let y = -self.focal * dot(q, self.up) + self.center[1] * w;
        Projected { h: [x, y, w], depth }
    }
    /// Returns the direction from a point of the scene to the camera.
    pub(crate) fn toward_camera(&self, p: Vec3) -> Vec3 {
        if self.perspective { unit(sub(self.eye, p)) } else { self.back }
    }
    /// Returns origin and direction of the ray through a sample (a step of 1 is a step of 1 in
    /// depth).
    pub(crate) fn ray(&self, x: f64, y: f64) -> (Vec3, Vec3) {
        let across = add(
            scale(self.right, (x - self.center[0]) / self.focal),
            scale(self.up, -(y - self.center[1]) / self.focal),
        );
        let forward = scale(self.back, -1.0);
        if self.perspective { (self.eye, add(forward, across)) } else { (add(self.eye, across), forward) }
    }
    /// Returns the depth key: larger is nearer, and linear over the samples of a planar face.
    pub(crate) fn depth_key(&self, depth: f64) -> f64 {
        if self.perspective { 1.0 / depth } else { -depth }
    }
    pub(crate) fn depth_of_key(&self, key: f64) -> f64 {
        if self.perspective { 1.0 / key } else { -key }
    }
    /// Returns the size of a sample in the scene at this depth.
    pub(crate) fn sample_size(&self, depth: f64) -> f64 {
        if self.perspective { depth / self.focal } else { 1.0 / self.focal }
    }

    /// Fits a view of these (normalised) points to the left part of the image, `free_width` pixels
    /// wide.
    pub(crate) fn fit(
        points: &[Vec3],
        triangles: &[[u32; 3]],
        positions: &[Vec3],
        normalization: &Normalization,
        options: &RenderOptions,
        free_width: f64,
    ) -> View {
        let camera = &options.camera;
        let base = Base::choose(triangles, positions, points, camera.up);
        let (azimuth, elevation) =
            (camera.azimuth.unwrap_or(base.azimuth), camera.elevation.unwrap_or(base.elevation));
        let side = cross(base.up, base.front);
        let level = add(scale(base.front, azimuth.cos()), scale(side, azimuth.sin()));
        let back = add(scale(level, elevation.cos()), scale(base.up, elevation.sin()));
        let right0 = add(scale(base.front, -azimuth.sin()), scale(side, azimuth.cos()));
        let up0 = cross(back, right0);
        let (s, c) = camera.roll.sin_cos();
        let right = add(scale(right0, c), scale(up0, s));
        let up = sub(scale(up0, c), scale(right0, s));

        let samples = options.supersampling as f64;
        let (width, height) = (free_width * samples, options.height as f64 * samples);
        let half = [width, height].map(|x| x / 2.0 * (1.0 - 2.0 * MARGIN));
        let perspective = matches!(camera.projection, Projection::Perspective { .. });
        let mut focal = match camera.projection {
            Projection::Perspective { field_of_view } => height / 2.0 / (field_of_view / 2.0).tan(),
            Projection::Orthographic => 1.0,
        };
        // Half the visible extent over distance: a point (x, y, z), z towards the camera, is
        // visible while |x| <= slope (d - z).
        let slope = if perspective { half.map(|h| h / focal) } else { [0.0; 2] };
        let mut reach = [[f64::NEG_INFINITY; 2]; 2]; // per axis: of x + slope z and of -x + slope z
        let mut nearest = f64::NEG_INFINITY;
        for &p in points {
            let z = dot(p, back);
            nearest = nearest.max(z);
            for (axis, x) in [dot(p, right), dot(p, up)].into_iter().enumerate() {
                reach[axis][0] = reach[axis][0].max(x + slope[axis] * z);
                reach[axis][1] = reach[axis][1].max(-x + slope[axis] * z);
            }
        }
        if points.is_empty() {
            (reach, nearest) = ([[1.0; 2]; 2], 1.0);
        }
        let middle = reach.map(|r| (r[0] - r[1]) / 2.0);
        let extent = reach.map(|r| ((r[0] + r[1]) / 2.0).max(1e-9));
        let mut distance = if perspective {
            (extent[0] / slope[0]).max(extent[1] / slope[1]).max(nearest + 10.0 * NEAR)
        } else {
            focal = (half[0] / extent[0]).min(half[1] / extent[1]);
            nearest + 1.0
        };
        focal *= camera.zoom;
        if let Some(d) = camera.distance {
            distance = normalization.length(d).clamp(1e-6, 1e12);
        }
        let target = match camera.target {
            Some(t) => normalization.apply(t).map(|x| x.clamp(-1e12, 1e12)),
            None => add(scale(right, middle[0]), scale(up, middle[1])),
        };
        View {
            perspective,
            eye: add(target, scale(back, distance)),
            right,
            up,
            back,
            focal,
            center: [width / 2.0, height / 2.0],
            world_up: base.up,
            has_ground: !base.flat,
        }
    }
}

/// Front and up directions, and default angles, before the camera is rotated.
struct Base {
    front: Vec3,
    up: Vec3,
    azimuth: f64,
    elevation: f64,
    flat: bool,
}

/// A mesh thinner than this, in units of the scene's radius, is flat.
const FLAT: f64 = 1e-4;
/// A mesh whose shortest side is below this fraction of its second shortest lies flat.
const LYING: f64 = 0.5;

impl Base {
    fn choose(triangles: &[[u32; 3]], positions: &[Vec3], points: &[Vec3], up_axis: UpAxis) -> Base {
        const AXES: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if let Some(normal) = flat_normal(triangles, positions) {
            let wanted = match up_axis {
                UpAxis::X => AXES[0],
                UpAxis::Auto | UpAxis::Y => AXES[1],
                UpAxis::Z => AXES[2],
            };
            // A mesh in the xz plane is seen like a map, with -z upwards.
            let instead = if up_axis == UpAxis::Z { AXES[1] } else { scale(AXES[2], -1.0) };
            let within = |a: Vec3| sub(a, scale(normal, dot(a, normal)));
            let up = if norm(within(wanted)) > 0.5 { within(wanted) } else { within(instead) };
            return Base { front: normal, up: unit(up), azimuth: 0.0, elevation: 0.0, flat: true };
        }
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let side = sub(high, low);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| side[a].total_cmp(&side[b]));
        let lying = !points.is_empty() && side[order[0]] < LYING * side[order[1]];
        let axis = match up_axis {
            UpAxis::X => 0,
            UpAxis::Y => 1,
            UpAxis::Z => 2,
            // A mesh that is thin along x stands, such as a figure that looks along z.
            UpAxis::Auto if lying && order[0] != 0 => order[0],
            UpAxis::Auto => 1,
        };
        let up = AXES[axis];
        let front = if axis == 2 { scale(AXES[1], -1.0) } else { AXES[2] };
        let degrees = if lying && axis == order[0] { 38.0f64 } else { 20.0 };
        Base { front, up, azimuth: 30f64.to_radians(), elevation: degrees.to_radians(), flat: false }
    }
}

/// Returns the normal of a flat mesh, on the side from which most of its area is counter-clockwise.
fn flat_normal(triangles: &[[u32; 3]], positions: &[Vec3]) -> Option<Vec3> {
    let corner = |v: u32| positions[v as usize];
    let mut widest = [0.0; 3];
    let mut sum = [0.0; 3];
    for &[a, b, c] in triangles {
        let n = cross(sub(corner(b), corner(a)), sub(corner(c), corner(a)));
        sum = add(sum, n);
        if dot(n, n) > dot(widest, widest) {
            widest = n;
        }
    }
    let normal = unit(widest);
    if normal == [0.0; 3] {
        return None;
    }
    // The largest face defines the plane; all corners must lie in it.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &v in triangles.iter().flatten() {
        let height = dot(corner(v), normal);
        (low, high) = (low.min(height), high.max(height));
    }
    (high - low <= FLAT).then(|| if dot(sum, normal) < 0.0 { scale(normal, -1.0) } else { normal })
}
