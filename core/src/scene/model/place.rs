//! Where the points of a body are at t = 0, and how they move.

use super::body::{Body, Pose, Source, Vec3, VelocityField};
use crate::boundary::{add, cross, dot, scale, sub};

impl Source {
    /// Points in the source's own frame \[m\]; none for shapes that are not made of points.
    ///
    /// A cloud fills its box as a cubic lattice, cell by cell with x running fastest, each point in the middle of a cell.
    pub fn points(&self) -> Option<Vec<Vec3>> {
        match self {
            Self::Points { positions_m } => Some(positions_m.clone()),
            Self::Cloud { count, size_m } => {
                let edge = (*count as f64).cbrt().ceil().max(1.0) as usize;
                let cells = [1, edge, edge * edge];
                let at = |i: usize, k: usize| ((i / cells[k] % edge) as f64 + 0.5) / edge as f64 - 0.5;
                Some((0..*count).map(|i| std::array::from_fn(|k| size_m[k] * at(i, k))).collect())
            }
            _ => None,
        }
    }
}

impl Pose {
    /// A direction of the own frame in the world.
    pub fn rotate(&self, direction: Vec3) -> Vec3 {
        // Rotation by the unit quaternion (q, w): p + 2 w q × p + q × (2 q × p). Written numbers are seldom quite unit.
        let [x, y, z, w] = self.orientation;
        let length = ((x * x + z * z) + (y * y + w * w)).sqrt();
        let (q, w) = ([x / length, y / length, z / length], w / length);
        let twice = scale(cross(q, direction), 2.0);
        add(add(scale(twice, w), cross(q, twice)), direction)
    }

    /// A point of the own frame in the world \[m\].
    pub fn apply(&self, point: Vec3) -> Vec3 {
        add(self.rotate(point), self.position_m)
    }
}

impl VelocityField {
    /// Velocity \[m/s\] of the point at `x` of a body with its centre of mass at `centre` \[m\], world frame.
    pub fn at(&self, x: Vec3, centre: Vec3) -> Vec3 {
        match *self {
            Self::Twist { linear_m_s, angular_rad_s } => add(linear_m_s, cross(angular_rad_s, sub(x, centre))),
            Self::LinearMap { linear_m_s, gradient_1_s, about_m } => {
                add(linear_m_s, gradient_1_s.map(|row| dot(row, sub(x, about_m))))
            }
            Self::Rotation { angular_rad_s, about_m } => cross(angular_rad_s, sub(x, about_m)),
        }
    }

    /// Velocity of the centre of mass at `centre` \[m/s\] and angular velocity \[rad/s\]; none of a field that deforms.
    pub fn twist(&self, centre: Vec3) -> Option<[Vec3; 2]> {
        let omega = match *self {
            Self::Twist { angular_rad_s, .. } | Self::Rotation { angular_rad_s, .. } => angular_rad_s,
            Self::LinearMap { gradient_1_s: g, .. } => {
                let largest = g.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
                // Rounding of the written numbers, no more.
                if (0..3).any(|i| (0..3).any(|j| (g[i][j] + g[j][i]).abs() > 1e-12 * largest)) {
                    return None;
                }
                [g[2][1], g[0][2], g[1][0]]
            }
        };
        Some([self.at(centre, centre), omega])
    }
}

impl Body {
    /// Positions \[m\] and velocities \[m/s\] at t = 0 of a body of equal points; none for shapes not made of points.
    pub fn points(&self) -> Option<(Vec<Vec3>, Vec<Vec3>)> {
        let x: Vec<Vec3> = self.source.points()?.into_iter().map(|p| self.pose.apply(p)).collect();
        let centre = scale(x.iter().fold([0.0; 3], |sum, &p| add(sum, p)), 1.0 / x.len().max(1) as f64);
        let v = x.iter().map(|&p| self.velocity.at(p, centre)).collect();
        Some((x, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::norm;
    use crate::scene::Material;

    /// A quarter turn about z: x becomes y.
    const QUARTER: Pose = Pose {
        position_m: [1.0, 2.0, 3.0],
        orientation: [0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2],
    };

    fn near(a: Vec3, b: Vec3) -> bool {
        // Roundings of numbers of order one.
        norm(sub(a, b)) < 1e-14
    }

    #[test]
    fn a_cloud_is_a_lattice_centred_in_its_box() {
        let cloud = |count| Source::Cloud { count, size_m: [2.0, 4.0, 8.0] }.points().unwrap();
        assert_eq!(cloud(0).len(), 0);
        assert!(near(cloud(1)[0], [0.0; 3]));
        let eight = cloud(8);
        let corners = [[-0.5, -1.0, -2.0], [0.5, -1.0, -2.0], [-0.5, 1.0, -2.0], [0.5, 1.0, -2.0], [-0.5, -1.0, 2.0]];
        assert!(eight.iter().zip(corners).all(|(&a, b)| near(a, b)), "{eight:?}");
        assert!(near(eight.iter().copied().fold([0.0; 3], add), [0.0; 3]));
        // Nine points need three cells a side; none lies on another.
        let nine = cloud(9);
        assert!((0..9).all(|i| (0..i).all(|k| norm(sub(nine[i], nine[k])) > 0.1)));
    }

    #[test]
    fn only_points_and_clouds_are_points() {
        let listed = vec![[1.0, 2.0, 3.0]];
        assert_eq!(Source::Points { positions_m: listed.clone() }.points(), Some(listed));
        assert_eq!(Source::Sphere { radius_m: 1.0 }.points(), None);
    }

    #[test]
    fn a_pose_turns_before_it_moves() {
        assert!(near(QUARTER.rotate([1.0, 0.0, 0.5]), [0.0, 1.0, 0.5]));
        assert!(near(QUARTER.apply([1.0, 0.0, 0.5]), [1.0, 3.0, 3.5]));
    }

    #[test]
    fn every_kind_of_field_gives_the_velocity_at_a_point() {
        let (x, centre, omega) = ([2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 3.0]);
        let twist = VelocityField::Twist { linear_m_s: [1.0, 0.0, 0.0], angular_rad_s: omega };
        let turning = VelocityField::Rotation { angular_rad_s: omega, about_m: [0.0; 3] };
        let gradient_1_s = [[0.0, -3.0, 0.0], [3.0, 0.0, 0.0], [0.0; 3]];
        let map = VelocityField::LinearMap { linear_m_s: [1.0, 0.0, 0.0], gradient_1_s, about_m: [0.0; 3] };
        assert!(near(twist.at(x, centre), [1.0, 3.0, 0.0]));
        assert!(near(turning.at(x, centre), [0.0, 6.0, 0.0]));
        assert!(near(map.at(x, centre), [1.0, 6.0, 0.0]));
    }

    #[test]
    fn the_points_of_a_body_turn_about_their_centre() {
        let mut body = Body {
            name: "pair".into(),
            solver: String::new(),
            material: Material::PointMass,
            source: Source::Points { positions_m: vec![[0.0; 3], [2.0, 0.0, 0.0]] },
            pose: QUARTER,
            mass_kg: None,
            spacing_m: None,
            velocity: VelocityField::Twist { linear_m_s: [0.0, 0.0, 5.0], angular_rad_s: [0.0, 0.0, 1.0] },
            prescribed: None,
            regions: Vec::new(),
            color: None,
        };
        let (x, v) = body.points().unwrap();
        assert!(near(x[0], [1.0, 2.0, 3.0]) && near(x[1], [1.0, 4.0, 3.0]), "{x:?}");
        assert!(near(v[0], [1.0, 0.0, 5.0]) && near(v[1], [-1.0, 0.0, 5.0]), "{v:?}");
        body.source = Source::Points { positions_m: Vec::new() };
        assert_eq!(body.points(), Some((Vec::new(), Vec::new())));
        body.source = Source::Plane { size_m: None };
        assert_eq!(body.points(), None);
    }
}
