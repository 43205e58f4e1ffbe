// SPDX-License-Identifier: MIT OR Apache-2.0
/// Where an increasing function reaches `target` inside a bracket: Newton steps, halved bracket where
/// they leave it. `function` returns value and derivative; the result is clamped to the bracket.
pub(crate) fn increasing(
    function: impl Fn(f64) -> (f64, f64),
    target: f64,
    bracket: [f64; 2],
    guess: f64,
) -> f64 {
    let [mut low, mut high] = bracket;
    let mut v = guess.clamp(low, high);
    for _ in 0..100 {
        let (value, derivative) = function(v);
        let excess = value - target;
        if excess > 0.0 {
            high = v;
        } else {
            low = v;
        }
        let newton = v - excess / derivative;
        let next = if newton >= low && newton <= high {
            newton
        } else {
            0.5 * (low + high)
        };
        let moved = (next - v).abs();
        v = next;
        if moved <= 2.0 * f64::EPSILON * v.abs().max(bracket[1] - bracket[0]) {
            break;
        }
    }
    v
}

/// Position of the minimum of a function that has one inside the bracket: golden section.
pub(crate) fn minimum(function: impl Fn(f64) -> f64, bracket: [f64; 2]) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut low, mut high] = bracket;
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (function(left), function(right));
    // the value is flat at the minimum: half the digits of the position are all there is
    for _ in 0..45 {
        if at_left <= at_right {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - ratio * (high - low);
            at_left = function(left);
        } else {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + ratio * (high - low);
            at_right = function(right);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kinked_function_is_inverted() {
        let kinked = |v: f64| {
            if v < 0.3 {
                (0.01 * v, 0.01)
            } else {
                (0.003 + 50.0 * (v - 0.3), 50.0)
            }
        };
        for (root, guess) in [
            (0.0, 0.9),
            (0.1, 0.1),
            (0.3, 0.0),
            (0.30001, 0.2),
            (1.0, 0.5),
        ] {
            let found = increasing(kinked, kinked(root).0, [0.0, 1.0], guess);
            assert!((found - root).abs() < 1e-14, "{root} {found}");
        }
    }

    #[test]
    fn minimum_of_a_parabola() {
        let found = minimum(|v| (v - 0.2) * (v - 0.2), [-1.0, 3.0]);
        assert!((found - 0.2).abs() < 1e-8);
    }
}
