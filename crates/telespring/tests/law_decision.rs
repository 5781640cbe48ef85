//! What counts in the answer beside the verdicts.

use telespring::decision::{Knowledge, Question, Status};
use telespring::study::Study;
use telespring::verdicts::{Assumption, Network, Tier};
use telespring::{Delay, hman};

/// The paper's robots over 0.1 s with this jitter (s), sampled at 1 kHz.
fn question(jitter: f64) -> Question {
    let network = Network::new(Delay::each_way(0.1 - jitter).unwrap(), jitter, 0.0, 0.001, 0.0).unwrap();
    Question::of_network(hman(), network)
}

/// The answer at a stiffness with something known.
fn answer(question: &Question, stiffness: f64, known: Knowledge) -> Status {
    question.decision(question.judge(stiffness).unwrap(), known).unwrap().status
}

/// The question of a study of the paper's robots with these sections.
fn of_study(sections: &str) -> Question {
    let robots =
        "robot1 = {mass = [0.8, 1.1], damping = [8, 10]}\nrobot2 = {mass = [0.8, 1.1], damping = [8, 10]}\n";
    Question::of_study(&Study::from_toml(&format!("{robots}{sections}")).unwrap(), None, [None, None])
        .unwrap()
}

#[test]
fn law_coupled_axes_take_away_what_was_proven() {
    let coupled = Knowledge { has_coupled_axes: true, ..Knowledge::default() };
    for (jitter, stiffness, alone, together) in [
        (0.0, 71.2, Status::Stable, Status::NotProven),
        (0.0, 97.0, Status::Marginal, Status::NotProven),
        (0.0, 110.0, Status::Unstable, Status::Unstable),
        (0.02, 60.0, Status::Stable, Status::NotProven),
        (0.02, 140.0, Status::Unstable, Status::Unstable),
    ] {
        let asked = question(jitter);
        assert_eq!(answer(&asked, stiffness, Knowledge::default()), alone, "{jitter} {stiffness}");
        assert_eq!(answer(&asked, stiffness, coupled), together, "{jitter} {stiffness}");
    }
}

#[test]
fn law_errors_of_the_robots_cost_the_word_stable() {
    let probable = |probability| Knowledge { stable_probability: Some(probability), ..Knowledge::default() };
    assert_eq!(answer(&question(0.0), 71.2, probable(0.95)), Status::Stable);
    assert_eq!(answer(&question(0.0), 71.2, probable(0.949)), Status::Marginal);
    assert_eq!(answer(&question(0.0), 110.0, probable(1.0)), Status::Unstable);
    let limited = |limit| Knowledge { varying_stiffness_limit: Some(limit), ..Knowledge::default() };
    assert_eq!(answer(&question(0.02), 60.0, limited(60.1)), Status::Stable);
    assert_eq!(answer(&question(0.02), 60.0, limited(59.9)), Status::Marginal);
}

#[test]
fn law_where_something_is_not_judged_nothing_is_proven_and_no_assumption_met() {
    let asked = of_study("network = {delay = 0.02}\nlaboratory = {actuator_lag = 0.01}\n");
    let decided = asked.decide(20.0).unwrap();
    assert_eq!(decided.status, Status::NotProven);
    assert!(decided.is_stable(), "it is not the stiffness");
    assert!(decided.verdicts.tiers.iter().all(|verdict| asked.assumption(verdict).is_none()));
}

#[test]
fn law_ages_without_a_bound_leave_what_holds_on_any_network() {
    let asked = of_study("network = {delay = 0.02, rate = 10}\ncontroller = {sample_period = 0.001}\n");
    assert!(!asked.is_bounded() && asked.is_varying());
    let judged = asked.judge(1.0).unwrap();
    for verdict in &judged.tiers {
        let met = (verdict.tier == Tier::AnyNetwork).then_some(Assumption::Met);
        assert_eq!(asked.assumption(verdict), met);
    }
    let allowed = asked.allowed(&judged).unwrap();
    assert_eq!(allowed.tier, Tier::AnyNetwork);
    assert_eq!(Some(allowed.stiffness), judged.tier(Tier::AnyNetwork).stiffness_bound);
    let softer = asked.decide(0.9 * allowed.stiffness).unwrap();
    assert_eq!(softer.status, Status::Stable);
    assert_eq!(softer.constant_delay_status, softer.status, "no buffer makes this delay constant");
    assert_ne!(asked.decide(1.01 * allowed.stiffness).unwrap().status, Status::Stable);
}

#[test]
fn law_free_handles_keep_the_robots_own_springs() {
    let asked = of_study("network.delay = 0.02\noperator1 = {stiffness = 100}\n");
    assert!(asked.is_held());
    let free = asked.released().unwrap();
    assert!(!free.is_held());
    assert_eq!(free.dyad, of_study("network.delay = 0.02\n").dyad);
    assert!(!of_study("network.delay = 0.02\n").is_held());
    let sprung = Study::from_toml(
        "robot1 = {mass = 1, damping = 5, ground_stiffness = 30}\nrobot2 = {mass = 1, damping = 5}\nnetwork.delay = 0.02\n",
    );
    let sprung = Question::of_study(&sprung.unwrap(), None, [None, None]).unwrap();
    assert!(!sprung.is_held(), "its own spring is no hand");
    assert_eq!(sprung.released().unwrap().dyad, sprung.dyad);
}

#[test]
fn law_the_worst_answer_is_the_greatest() {
    assert!(Status::ALL.is_sorted());
    assert_eq!(Status::ALL.map(Status::word), ["stable", "marginal", "not proven", "unstable"]);
}
