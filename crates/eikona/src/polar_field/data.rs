//! The values that determine a field, to be stored and read without loss.

use crate::polar_field::bevel::{Cycle, wrapped};
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::field::Values;
use crate::polar_field::problem::check_degree;
use crate::polar_field::singularity::{Place, Prescribed, Singularity, located};
use crate::polar_field::solution::{FieldReport, PolarField};
use crate::polar_field::surface::Surface;
use eikona_mesh::{FaceField, HalfedgeField, Located, SurfacePoint, TriangleMesh, Vertex};
use eikona_numeric::{Complex, check_step, check_stopped};

/// The values that determine a field on a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldData {
    /// The number N of directions.
    pub degree: u32,
    /// The faces of the mesh, consistently oriented.
    pub triangles: Vec<[u32; 3]>,
    /// The power in each face, at least 1.
    pub powers: Vec<u32>,
    /// The linear field at each corner, face by face: components along the face's first side and
    /// across. The N-th power of the field is its interpolation to the power of the face.
    pub base: Vec<[f64; 2]>,
    /// How far the N-th power turns at the origin of each halfedge, from the face of its twin to
    /// its own, in radians; zero at the boundary.
    pub turns: Vec<f64>,
    /// The prescribed indices.
    pub singularities: Vec<Singularity>,
}

/// Largest difference between a rotation and the phases of the corners, in radians.
const CONSISTENT: f64 = 1e-6;

impl PolarField {
    /// Returns the values that determine the field.
    pub fn data(&self) -> FieldData {
        let mesh = self.mesh();
        FieldData {
            degree: self.degree,
            triangles: mesh.triangles().to_vec(),
            powers: self.values.powers.as_slice().to_vec(),
            base: self.values.base.iter().map(|z| [z.re, z.im]).collect(),
            turns: self.values.jump.as_slice().to_vec(),
            singularities: self.singularities(),
        }
    }

    /// Restores a field from its values and its mesh, to the last digit.
    ///
    /// The report has measured indices, closure and largest power; all else is at its default.
    ///
    /// # Errors
    /// [`PolarFieldError::OtherMesh`] if the values were made for another mesh;
    /// [`PolarFieldError::Degree`], [`PolarFieldError::Point`] and other faults of the
    /// prescription; the errors of [`Solver::new`](super::Solver::new) about the surface.
    ///
    /// # Cost
    /// O(F).
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::polar_field::{FieldOptions, PolarField, Solver};
    /// let torus = shapes::torus(1.0, 0.4, 16, 8)?;
    /// let solver = Solver::new(&torus, &Default::default())?;
    /// let data = solver.solve(&[], &FieldOptions::default())?.data();
    /// assert_eq!(PolarField::from_data(&torus, &data)?.data(), data);
    /// assert!(PolarField::from_data(&shapes::icosphere(1)?, &data).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_data(mesh: &TriangleMesh, data: &FieldData) -> Result<PolarField, PolarFieldError> {
        check_degree(data.degree)?;
        let domain = Domain::new(Surface::of(mesh)?.bevel)?;
        let mesh = &domain.bevel.mesh;
        let sizes = [
            ("powers", data.powers.len(), mesh.face_count()),
            ("values at corners", data.base.len(), mesh.halfedge_count()),
            ("rotations", data.turns.len(), mesh.halfedge_count()),
        ];
        for (what, found, expected) in sizes {
            if found != expected {
                return Err(PolarFieldError::OtherMesh {
                    what: format!("it has {found} {what}, not {expected}"),
                });
            }
        }
        if let Some(f) = mesh.triangles().iter().zip(&data.triangles).position(|(own, other)| own != other) {
            return Err(PolarFieldError::OtherMesh { what: format!("face {f} has other vertices") });
        }
        if let Some(f) = data.powers.iter().position(|&m| m == 0) {
            return Err(PolarFieldError::OtherMesh { what: format!("the power of face {f} is 0") });
        }
        let finite = |x: &f64| x.is_finite();
        if !(data.base.iter().flatten().all(finite) && data.turns.iter().all(finite)) {
            return Err(PolarFieldError::OtherMesh { what: "some of its values are not finite".into() });
        }
        let base = data.base.iter().map(|&[re, im]| Complex { re, im }).collect();
        let jump = HalfedgeField::from(data.turns.clone());
        let powers = FaceField::from(data.powers.clone());
        let mut values = Values { base, powers, jump, closure: 0.0 };
        let mut closure = (0.0f64, 0);
        for (h, twin) in domain.bevel.interior() {
            check_step(h.index())?;
            let seen = values.jump(h, twin, &domain.connection, data.degree);
            let difference = wrapped(seen - values.jump[h]).abs();
            if difference > closure.0 {
                closure = (difference, h.face().index());
            }
        }
        if closure.0 > CONSISTENT {
            let what = format!("it does not fit the shape of face {}", closure.1);
            return Err(PolarFieldError::OtherMesh { what });
        }
        values.closure = closure.0;
        check_stopped()?;
        let mut singular = located(&domain.bevel, &data.singularities, data.degree)?;
        for (prescribed, stored) in singular.iter_mut().zip(&data.singularities) {
            keep_digits(mesh, prescribed, stored);
        }
        let n = f64::from(data.degree);
        let curvature = &domain.curvature;
        let seen = values.measured(&domain.bevel, &domain.connection, |c| curvature[c], data.degree)?;
        let report = FieldReport {
            closure: values.closure,
            measured: singular.iter().map(|s| seen[s.cycle] as f64 / n).collect(),
            largest_power: data.powers.iter().max().copied().unwrap_or(1),
            ..FieldReport::default()
        };
        let (domain, degree) = (domain.into(), data.degree);
        Ok(PolarField { domain, values, degree, singular, lowest_corners: Vec::new(), report })
    }

    /// Returns the prescribed indices, those of boundary loops and of value zero included.
    pub fn singularities(&self) -> Vec<Singularity> {
        let singularity = |s: &Prescribed| {
            let place = match (s.point, s.cycle) {
                (Some(point), _) => Place::Point(point.to_surface_point(self.mesh())),
                (None, Cycle::Boundary(b)) => Place::Boundary(b as usize),
                (None, _) => return None,
            };
            Some(Singularity { place, index: s.turns as f64 / f64::from(self.degree) })
        };
        self.singular.iter().filter_map(singularity).collect()
    }
}

/// Takes the stored weights of a point in a face: to locate it again would normalise them again.
fn keep_digits(mesh: &TriangleMesh, prescribed: &mut Prescribed, stored: &Singularity) {
    if let (Some(Located::Face(face, weights)), Place::Point(SurfacePoint::Face { vertices, bary })) =
        (&mut prescribed.point, stored.place)
    {
        let weight_of = |v: Vertex| vertices.iter().zip(bary).find(|(u, _)| **u == v.0).map(|(_, w)| w);
        for (weight, v) in weights.iter_mut().zip(mesh.face_vertices(*face)) {
            *weight = weight_of(v).unwrap_or(*weight);
        }
    }
}
