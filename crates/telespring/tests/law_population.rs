//! Counts of a population: parts add up to the whole, and the counts are those of the criteria.

use proptest::prelude::*;
use telespring::DyadAxis;
use telespring::criteria::{critical_stiffness, paper_critical_stiffness};
use telespring::population::{BIN_RATIO, LogRange, Population, Tally};

fn population(ratio: LogRange, cells: [usize; 2], operator: f64) -> Population {
    let mass = LogRange { low: 0.5, high: 5.0 };
    let damping = LogRange { low: 1.0, high: 20.0 };
    let seed = 7;
    let [mass_ratio, damping_ratio] = [ratio; 2];
    let (operator_mass, operator_damping) = (operator, 3.0 * operator);
    Population { mass, damping, mass_ratio, damping_ratio, cells, operator_mass, operator_damping, seed }
        .checked()
        .unwrap()
}

fn sum(parts: &[Tally]) -> Tally {
    let mut whole = Tally::empty();
    for part in parts {
        whole.dyads += part.dyads;
        whole.unsafe_dyads += part.unsafe_dyads;
        whole.largest = whole.largest.max(part.largest);
        for (bin, more) in whole.histogram.iter_mut().zip(&part.histogram) {
            *bin += more;
        }
    }
    whole
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]
    #[test]
    fn law_parts_add_up_to_the_whole(cuts in prop::collection::vec(0_u64..300, 0..5), operator in 0.0..2.0) {
        let population = population(LogRange { low: 0.02, high: 50.0 }, [2, 3], operator);
        let mut edges = [cuts, vec![0, 300]].concat();
        edges.sort_unstable();
        for cell in 0..6 {
            let parts: Vec<_> = edges
                .windows(2)
                .map(|edge| population.tally(cell, edge[0], edge[1] - edge[0]).unwrap())
                .collect();
            prop_assert_eq!(sum(&parts), population.tally(cell, 0, 300).unwrap());
        }
    }
}

/// A cell without width has one ratio, on which alone the ratio of the two stiffnesses depends.
#[test]
fn law_a_cell_without_width_counts_what_the_criteria_say_of_its_dyad() {
    for (ratio, is_unsafe) in [(1.0, false), (30.0, true)] {
        let damping_ratio = LogRange { low: ratio, high: ratio };
        let mass_ratio = LogRange { low: 1.0, high: 1.0 };
        let population = Population { mass_ratio, ..population(damping_ratio, [1, 1], 0.0) };
        let axis = DyadAxis::new(1.0, 1.0, 1.0, ratio).unwrap();
        let expected = paper_critical_stiffness(&axis).unwrap() / critical_stiffness(&axis);
        let tally = population.tally(0, 0, 200).unwrap();
        assert_eq!(tally.unsafe_dyads, if is_unsafe { 200 } else { 0 });
        assert!((tally.largest / expected - 1.0).abs() < 1e-9);
        if is_unsafe {
            let bin = tally.histogram.iter().position(|&count| count == 200).unwrap();
            let [low, high] = [bin, bin + 1].map(|edge| BIN_RATIO.powi(i32::try_from(edge).unwrap()));
            assert!(low <= expected && expected < high, "{low} {expected} {high}");
        }
    }
}

/// Robots with swapped roles are the same dyad: the map is symmetric about equal ratios, up to chance.
#[test]
fn law_swapping_the_robots_changes_nothing_but_chance() {
    let population = population(LogRange { low: 0.1, high: 10.0 }, [2, 2], 0.0);
    let share = |cell| population.tally(cell, 0, 20_000).unwrap().unsafe_dyads as f64 / 20_000.0;
    assert!((share(0) - share(3)).abs() < 0.03);
    assert!((share(1) - share(2)).abs() < 0.03);
}

#[test]
fn law_a_population_that_cannot_be_drawn_is_refused() {
    let good = population(LogRange { low: 0.1, high: 10.0 }, [1, 1], 0.0);
    let field = |population: Population| population.checked().unwrap_err().field;
    assert_eq!(field(Population { mass: LogRange { low: 2.0, high: 1.0 }, ..good }), "mass");
    assert_eq!(field(Population { damping: LogRange { low: 0.0, high: 1.0 }, ..good }), "damping");
    assert_eq!(field(Population { cells: [0, 3], ..good }), "cells");
    let wide = LogRange { low: 1e-9, high: 1.0 };
    assert_eq!(field(Population { mass_ratio: wide, ..good }), "mass_ratio (mass of robot 2)");
}
