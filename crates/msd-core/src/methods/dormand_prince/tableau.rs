//! Coefficients of the method of Dormand and Prince.
//!
//! For x'' = a(x, v) the seven stages are, with a_l the acceleration at stage l and A the table,
//!
//! v_i = v + h Σ A_il a_l,  x_i = x + h c_i v + h² Σ (A²)_il a_l,
//!
//! the method applied to (x, v) with the velocities put into the positions: seven columns are kept
//! instead of fourteen. The last row of the table is the method itself, so that the last stage of
//! an accepted substep is the first of the next.
//!
//! Sources: Dormand and Prince (1980), J. Comput. Appl. Math. 6, 19-26, table 2; dense output:
//! Shampine (1986), Math. Comp. 46, 135-150, in the form of Hairer, Nørsett and Wanner (1993),
//! Solving Ordinary Differential Equations I, section II.6 and their code DOPRI5.

/// Stages of a substep, the first of the next one included.
pub(crate) const STAGES: usize = 7;

/// A number per stage.
pub(crate) type Row = [f64; STAGES];

/// A.
pub(crate) const SLOPES: [Row; STAGES] = [
    [0.0; STAGES],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0, 0.0],
];

/// c: the time of each stage as a fraction of the substep.
pub(crate) const TIMES: Row = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// A²: the weights of accelerations in positions.
pub(crate) const BENDS: [Row; STAGES] = {
    let mut bends = [[0.0; STAGES]; STAGES];
    let mut row = 0;
    while row < STAGES {
        bends[row] = bend(SLOPES[row]);
        row += 1;
    }
    bends
};

/// Weights of the difference between the results of order 5 and 4, for velocities.
pub(crate) const ERROR_SLOPE: Row = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The same for positions.
pub(crate) const ERROR_BEND: Row = bend(ERROR_SLOPE);

/// Weights of the term that gives the interpolant its fourth order.
const DENSE: Row = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// The weights b(θ) of the state at a fraction θ of a substep, of fourth order: the velocity is
/// v + h Σ b_l a_l. At θ = 1 they are the last row of the table.
pub(crate) fn dense_slope(fraction: f64) -> Row {
    let rest = 1.0 - fraction;
    let mut weights = [0.0; STAGES];
    for (stage, weight) in weights.iter_mut().enumerate() {
        let whole = SLOPES[STAGES - 1][stage];
        let first = if stage == 0 { 1.0 } else { 0.0 } - whole;
        let last = if stage == STAGES - 1 { -1.0 } else { 0.0 } + whole - first;
        *weight = fraction * (whole + rest * (first + fraction * (last + rest * DENSE[stage])));
    }
    weights
}

/// A row of weights for velocities turned into one for positions: row · A.
pub(crate) const fn bend(row: Row) -> Row {
    let mut bent = [0.0; STAGES];
    let mut stage = 0;
    while stage < STAGES {
        let mut column = 0;
        while column < stage {
            bent[column] += row[stage] * SLOPES[stage][column];
            column += 1;
        }
        stage += 1;
    }
    bent
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(a: &Row, b: &Row) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// A row of A times powers of the times, for each stage.
    fn stages(of: &Row) -> Row {
        core::array::from_fn(|stage| dot(&SLOPES[stage], of))
    }

    /// The conditions of order four on the weights at θ, one for each rooted tree of at most four
    /// nodes: Σ b_i(θ) Φ_i = θ^nodes / γ (Hairer, Nørsett and Wanner, 1993, theorem II.6.1).
    #[test]
    fn the_interpolant_has_order_four_and_ends_in_the_method() {
        let power = |exponent| TIMES.map(|time: f64| time.powi(exponent));
        let (one, c) = (power(0), TIMES);
        let product = |a: Row, b: Row| core::array::from_fn(|stage| a[stage] * b[stage]);
        let trees = [
            (one, 1, 1.0),
            (c, 2, 2.0),
            (power(2), 3, 3.0),
            (stages(&c), 3, 6.0),
            (power(3), 4, 4.0),
            (product(c, stages(&c)), 4, 8.0),
            (stages(&power(2)), 4, 12.0),
            (stages(&stages(&c)), 4, 24.0),
        ];
        for fraction in [0.1, 0.25, 0.5, 0.75, 1.0_f64] {
            let weights = dense_slope(fraction);
            for (tree, nodes, density) in trees {
                let exact = fraction.powi(nodes) / density;
                let error = dot(&weights, &tree) - exact;
                // Seven terms of at most five, each rounded a few times.
                assert!(error.abs() <= 100.0 * f64::EPSILON, "{fraction}, {nodes}, {density}");
            }
        }
        assert_eq!(dense_slope(1.0), SLOPES[STAGES - 1]);
    }
}
