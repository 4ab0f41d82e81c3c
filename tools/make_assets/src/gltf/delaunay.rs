//! Delaunay triangulation of a few hundred points by the Bowyer–Watson algorithm.

/// Triangulates `points`, whose outline must be convex. Triangles are counter-clockwise.
pub(super) fn triangulate(points: &[[f64; 2]]) -> Vec<[usize; 3]> {
    // The super-triangle contains all points at first; at the end it is removed with all triangles at its corners.
    const FAR: f64 = 1.0e5;
    let mut all = points.to_vec();
    all.extend([[-FAR, -FAR], [FAR, -FAR], [0.0, FAR]]);
    let first_outside = points.len();
    let mut triangles = vec![[first_outside, first_outside + 1, first_outside + 2]];

    for (index, &point) in points.iter().enumerate() {
        let (gone, kept): (Vec<_>, Vec<_>) = triangles
            .into_iter()
            .partition(|triangle| in_circumcircle(triangle.map(|corner| all[corner]), point));
        triangles = kept;
        let edges = || gone.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        for [from, to] in edges() {
            let inside = edges().any(|edge| edge == [to, from]);
            if !inside {
                triangles.push([from, to, index]);
            }
        }
    }

    // Collinear points along the outline can leave triangles without area there, by rounding.
    triangles.retain(|&triangle| {
        triangle.iter().all(|&corner| corner < first_outside)
            && area(triangle.map(|corner| all[corner])) > 1.0e-9
    });
    triangles
}

/// Whether `p` is inside the circle through a counter-clockwise triangle.
fn in_circumcircle(triangle: [[f64; 2]; 3], p: [f64; 2]) -> bool {
    let [a, b, c] = triangle.map(|[x, y]| {
        let (x, y) = (x - p[0], y - p[1]);
        [x, y, x * x + y * y]
    });
    let determinant = a[0] * (b[1] * c[2] - c[1] * b[2]) - b[0] * (a[1] * c[2] - c[1] * a[2])
        + c[0] * (a[1] * b[2] - b[1] * a[2]);
    determinant > 0.0
}

fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
}
