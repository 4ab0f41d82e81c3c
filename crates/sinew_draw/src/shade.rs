//! Colours the samples and averages them to pixels: the last stage, and the function that runs all stages.

use glam::Vec3;

use super::backdrop::Backdrop;
use super::camera::View;
use super::geometry::{self, Source, Triangle};
use super::image::Image;
use super::image::{SrgbTable, linear_of, tone};
use super::occlusion::{self, Facet, each_row};
use super::raster::{self, Fragment, Samples};
use super::scene::Scene;
use super::shadow::ShadowMap;

/// Samples along each side of a pixel.
const FINE: usize = 2;

/// Light of the sun, of the sky above and reflected from the ground; linear, on a white surface.
const SUN: Vec3 = Vec3::new(1.02, 0.96, 0.86);
const SKY: Vec3 = Vec3::new(0.46, 0.52, 0.61);
const BOUNCE: Vec3 = Vec3::new(0.33, 0.31, 0.29);

/// Fraction of the sunlight that shines through a double-sided item.
const THROUGH: f32 = 0.35;

/// Renders a scene to `width` × `height` pixels, with four samples each.
pub fn render(scene: &Scene, width: usize, height: usize) -> Image {
    let mut image = Image::new(width, height, [0, 0, 0, 255]);
    if width == 0 || height == 0 {
        return image;
    }
    let view = View::new(&scene.camera, width as f32 / height as f32);
    let size = [width * FINE, height * FINE];
    let triangles = geometry::triangles(scene, &view, size[1]);
    let detail = (width.max(height) * 2).next_power_of_two().clamp(1024, 2048);
    // The shadow map and the camera's samples, in parallel.
    let (shadow, samples) = std::thread::scope(|scope| {
        let shadow = scope.spawn(|| ShadowMap::new(&triangles, scene.sun, &view, detail));
        let samples = raster::nearest(size, view.near, triangles.len(), |t| {
            let triangle = &triangles[t];
            (!triangle.hidden).then(|| triangle.positions.map(|p| view.clip(p)))
        });
        (shadow.join().expect("drawing a shadow does not panic"), samples)
    });
    let shader = Shader {
        scene,
        colors: scene.items.iter().map(|item| linear_of(item.color)).collect(),
        shadow,
        backdrop: Backdrop::new(&view, scene.ground),
        pixel: view.pixel(size[1]),
        view,
        triangles,
        samples,
        size,
    };

    // Ambient light varies slowly: one sample a pixel is enough.
    let nothing = Facet { depth: f32::INFINITY, normal: Vec3::Y, solid: false };
    let mut facets = vec![nothing; width * height];
    each_row(&mut facets, width, |y, row| {
        for (x, facet) in row.iter_mut().enumerate() {
            *facet = shader.facet([x * FINE, y * FINE]);
        }
    });
    let open = occlusion::openness(&shader.view, &facets, width, height);

    let table = SrgbTable::new();
    each_row(&mut image.pixels, width, |y, row| {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = table.pixel(shader.pixel([x, y], open[y * width + x]));
        }
    });
    image
}

struct Shader<'a> {
    scene: &'a Scene<'a>,
    /// Colours of the items, linear.
    colors: Vec<Vec3>,
    view: View,
    triangles: Vec<Triangle>,
    samples: Samples,
    shadow: ShadowMap,
    backdrop: Backdrop,
    size: [usize; 2],
    /// Width of a sample at distance 1.
    pixel: f32,
}

/// What is visible at a sample.
enum Seen<'a> {
    Triangle(&'a Triangle, [f32; 3]),
    Ground(f32),
    Sky,
}

impl Seen<'_> {
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Seen::Sky, Seen::Sky) | (Seen::Ground(_), Seen::Ground(_)) => true,
            (Seen::Triangle(a, _), Seen::Triangle(b, _)) => std::ptr::eq(*a, *b),
            _ => false,
        }
    }

    fn weight(&self, corner: usize) -> f32 {
        match self {
            Seen::Triangle(_, weights) => weights[corner],
            _ => 0.0,
        }
    }
}

impl Shader<'_> {
    /// Colour of a pixel, linear; `open` is the unoccluded fraction of the sky.
    fn pixel(&self, [x, y]: [usize; 2], open: f32) -> Vec3 {
        let samples =
            [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| [x * FINE + dx, y * FINE + dy]);
        if samples.iter().all(|sample| self.fragment(*sample).triangle == Fragment::NONE.triangle) {
            // The ground fades into the sky: there is no edge between them to antialias.
            let ray = self.ray(samples[0], 1.0);
            return self.color(&self.behind(ray), ray, FINE as f32, open);
        }
        let rays = samples.map(|sample| self.ray(sample, 0.5));
        let seen = [0, 1, 2, 3].map(|i| self.seen(samples[i], rays[i]));
        if seen.iter().all(|other| other.is_like(&seen[0])) {
            // No edge to antialias, as in most pixels: the middle is shaded for the whole pixel.
            let ray = self.ray(samples[0], 1.0);
            let middle = match seen[0] {
                Seen::Sky | Seen::Ground(_) => self.behind(ray),
                Seen::Triangle(triangle, _) => {
                    let weight =
                        |corner: usize| seen.iter().map(|s| s.weight(corner)).sum::<f32>() * 0.25;
                    Seen::Triangle(triangle, [0, 1, 2].map(weight))
                }
            };
            return self.color(&middle, ray, FINE as f32, open);
        }
        let colors = seen.iter().zip(rays).map(|(seen, ray)| self.color(seen, ray, 1.0, open));
        colors.sum::<Vec3>() * 0.25
    }

    /// Tone-mapped colour at a sample, still linear, over a width in samples.
    fn color(&self, seen: &Seen, ray: Vec3, width: f32, open: f32) -> Vec3 {
        tone(match *seen {
            Seen::Sky => self.backdrop.sky(ray),
            Seen::Ground(depth) => self.ground(ray, depth, width, open),
            Seen::Triangle(triangle, weights) => match triangle.source {
                Source::Line(index) => linear_of(self.scene.lines[index].color),
                Source::Item(index) => self.surface(index, triangle, weights, width, open),
            },
        })
    }

    /// The values of a sample that ambient occlusion reads.
    fn facet(&self, sample: [usize; 2]) -> Facet {
        let (depth, normal, solid) = match self.seen(sample, self.ray(sample, 0.5)) {
            Seen::Sky => (f32::INFINITY, Vec3::Y, false),
            Seen::Ground(depth) => (depth, Vec3::Y, false),
            Seen::Triangle(triangle, weights) => {
                let depth = self.view.depth(mix(triangle.positions, weights));
                (depth, mix(triangle.normals, weights).normalize_or(triangle.face), true)
            }
        };
        Facet { depth, normal: self.view.turned(normal), solid }
    }

    /// Ray through a sample, offset by `within` samples from its top left corner.
    #[inline]
    fn ray(&self, [x, y]: [usize; 2], within: f32) -> Vec3 {
        let across = (x as f32 + within) * 2.0 / self.size[0] as f32 - 1.0;
        let up = 1.0 - (y as f32 + within) * 2.0 / self.size[1] as f32;
        self.view.ray(across, up)
    }

    #[inline]
    fn fragment(&self, [x, y]: [usize; 2]) -> Fragment {
        self.samples.fragments.as_ref()[y * self.size[0] + x]
    }

    /// Ground or sky, where there is no triangle.
    fn behind(&self, ray: Vec3) -> Seen<'_> {
        let ground = self.backdrop.ground_depth(self.view.eye, ray);
        ground.map_or(Seen::Sky, Seen::Ground)
    }

    #[inline]
    fn seen(&self, sample: [usize; 2], ray: Vec3) -> Seen<'_> {
        let fragment = self.fragment(sample);
        let Some(triangle) = self.triangles.get(fragment.triangle as usize) else {
            return self.behind(ray);
        };
        let depth =
            self.view.near / self.samples.depth.as_ref()[sample[1] * self.size[0] + sample[0]];
        match self.backdrop.ground_depth(self.view.eye, ray) {
            // A triangle exactly on the ground is drawn above it.
            Some(ground) if ground < depth * 0.9995 => Seen::Ground(ground),
            _ => {
                let [a, b] = fragment.weights;
                Seen::Triangle(triangle, [a, b, 1.0 - a - b])
            }
        }
    }

    fn ground(&self, ray: Vec3, depth: f32, width: f32, open: f32) -> Vec3 {
        let point = self.view.eye + ray * depth;
        let across = self.pixel * width * depth;
        // Seen at an angle, a sample covers a longer stretch of the ground along the view direction than across it.
        let slant = ray.length() / ray.y.abs();
        let flat = ray.with_y(0.0).normalize_or_zero();
        let stretch = |along: f32| across * (1.0 + (slant - 1.0) * along.abs());
        let (color, fade) = self.backdrop.ground(point, [stretch(flat.x), stretch(flat.z)]);
        let horizon = self.backdrop.sky(ray.with_y(0.0));
        if fade >= 1.0 {
            return horizon;
        }
        // In full light the ground has exactly its own colour, whatever the height of the sun: only shadows darken it.
        let cosine = self.shadow.sun.y.max(0.0);
        let lit = if cosine > 0.0 { self.shadow.light(point, Vec3::Y) } else { 0.0 };
        let light = (SKY * open + SUN * (cosine * lit)) / (SKY + SUN * cosine);
        (color * light).lerp(horizon, fade)
    }

    fn surface(
        &self,
        index: usize,
        triangle: &Triangle,
        weights: [f32; 3],
        width: f32,
        open: f32,
    ) -> Vec3 {
        let item = &self.scene.items[index];
        let point = mix(triangle.positions, weights);
        let normal = mix(triangle.normals, weights).normalize_or(triangle.face);
        let mut color = self.colors[index];
        if let (Some(texture), Some(_)) = (&item.texture, &item.uvs) {
            let [a, b, c] = triangle.uvs;
            color *= texture.sample(
                a * weights[0] + b * weights[1] + c * weights[2],
                triangle.lod + width.log2(),
            );
        }

        let sun = self.shadow.sun;
        let facing = normal.dot(sun);
        let to_eye = (self.view.eye - point).normalize_or_zero();
        let sky = BOUNCE.lerp(SKY, normal.y * 0.5 + 0.5) * open;
        let mut light = sky;
        let mut shine = 0.0;
        if facing > 0.0 {
            let lit = self.shadow.light(point, triangle.face);
            light += SUN * (facing * lit);
            let half = (sun + to_eye).normalize_or_zero();
            shine = lit * facing.min(0.25) * 4.0 * 0.16 * normal.dot(half).max(0.0).powi(48);
        } else if item.double_sided {
            light += SUN * (THROUGH * -facing * self.shadow.light(point, -triangle.face));
        }
        // Fresnel term: at a grazing angle every surface reflects a little of the sky.
        let rim = (1.0 - normal.dot(to_eye).clamp(0.0, 1.0)).powi(4) * 0.22;
        let mirrored = self.backdrop.horizon.lerp(self.backdrop.zenith, 0.4) * open;
        (color * light).lerp(mirrored, rim) + SUN * shine
    }
}

fn mix(corners: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}
