//! Progress on standard error: a moving line on a terminal, a line now and then elsewhere.

use crate::counts::Counts;
use crate::output;
use indicatif::{ProgressBar, ProgressStyle};
use locotamp::Event;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Time between two lines when standard error is not a terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);

/// Where progress is shown.
enum Sink {
    Terminal(ProgressBar),
    Lines { last: Option<Instant> },
    Nowhere,
}

/// What a run has done so far, and where that is shown.
pub(crate) struct Progress {
    sink: Sink,
    begin: Instant,
    /// True if the contact sequence is given, so that none are counted.
    given: bool,
    /// Sequences drawn so far, those that wait for their turn included.
    drawn: usize,
    counts: Counts,
    solutions: usize,
    /// Time of the first plan [s].
    first_after: Option<f64>,
    /// Cost and number of the best plan.
    best: Option<(f64, usize)>,
    doing: String,
}

impl Progress {
    /// Progress to standard error, or to nowhere.
    pub fn new(quiet: bool) -> Self {
        let sink = if quiet {
            Sink::Nowhere
        } else if std::io::stderr().is_terminal() {
            Sink::Terminal(spinner())
        } else {
            Sink::Lines { last: None }
        };
        Self {
            sink,
            begin: Instant::now(),
            given: false,
            drawn: 0,
            counts: Counts::default(),
            solutions: 0,
            first_after: None,
            best: None,
            doing: "reading".into(),
        }
    }

    /// Progress on one given sequence.
    pub fn of_one_sequence(quiet: bool) -> Self {
        Self {
            given: true,
            ..Self::new(quiet)
        }
    }

    /// Takes note of an event and shows it.
    pub fn see(&mut self, event: &Event) {
        let news = self.note(event);
        let line = self.line();
        let elapsed = self.begin.elapsed().as_secs_f64();
        match &mut self.sink {
            Sink::Terminal(bar) => {
                if let Some(news) = news {
                    bar.println(news);
                }
                bar.set_message(line);
            }
            Sink::Lines { last } => {
                if let Some(news) = news {
                    output::error(&format!("[{elapsed:6.1} s] {news}\n"));
                    *last = Some(Instant::now());
                } else if last.is_none_or(|at| at.elapsed() >= LINE_EVERY) {
                    output::error(&format!("[{elapsed:6.1} s] {line}\n"));
                    *last = Some(Instant::now());
                }
            }
            Sink::Nowhere => {}
        }
    }

    /// Ends the moving line.
    pub fn finish(&self) {
        if let Sink::Terminal(bar) = &self.sink {
            bar.finish_and_clear();
        }
    }

    /// What messages call the sequence.
    fn title(&self, number: usize) -> String {
        if number == 0 {
            "refinement".into()
        } else if self.given {
            "the sequence".into()
        } else {
            format!("sequence {number}")
        }
    }

    /// Updates the counts; returns what deserves a line of its own.
    fn note(&mut self, event: &Event) -> Option<String> {
        match event {
            Event::Started {
                interfaces,
                contacts,
                max_phases,
                skeleton,
            } => {
                self.doing = "searching contact sequences".into();
                return Some(format!(
                    "{interfaces} interfaces, {contacts} possible contacts, at least {skeleton} manipulation actions, at most \
                     {max_phases} phases"
                ));
            }
            Event::Sequence { number, labels } => {
                self.drawn = *number;
                self.doing = format!("keyframes of {} phases", labels.len());
            }
            Event::Keyframes {
                number, possible, ..
            } => {
                if *possible {
                    self.doing = "optimising".into();
                    return Some(format!("{}: keyframes found", self.title(*number)));
                }
                self.doing = "searching contact sequences".into();
            }
            Event::Iteration {
                number,
                iteration,
                violation,
                objective,
            } => {
                self.doing = format!(
                    "{}, iteration {iteration}: violation {violation:.1e}, cost {objective:.3}",
                    self.title(*number)
                );
            }
            Event::Solution { number, best, plan } => {
                self.solutions += 1;
                let seconds = self.begin.elapsed().as_secs_f64();
                self.first_after.get_or_insert(seconds);
                let cost = plan.objective.as_ref().and_then(|o| o.cost);
                if let Some(cost) = cost.filter(|_| *best) {
                    self.best = Some((cost, *number));
                    let phases = plan.phases.iter().skip(1);
                    let story: Vec<&str> = phases.map(|p| p.action.as_str()).collect();
                    return Some(format!("best so far: {}", story.join(" | ")));
                }
            }
            Event::Refining { max_step } => {
                self.doing = "refining".into();
                return Some(format!(
                    "refining the motion to steps of at most {:.0} ms",
                    1e3 * max_step
                ));
            }
            Event::Tried { reached, .. } => self.counts.add(*reached),
            Event::Explaining {
                doing,
                solves,
                iteration,
            } => {
                self.doing = format!("explaining, solve {solves}: {doing}, iteration {iteration}");
            }
            Event::Coarse { number, cost } => {
                let title = self.title(*number);
                return Some(format!("{title}: a coarse motion, cost {cost:.3}"));
            }
            Event::Optimised {
                number,
                feasible,
                cost,
                reason,
            } => {
                let title = self.title(*number);
                return Some(match (feasible, reason) {
                    (true, _) => format!("{title}: feasible, cost {cost:.3}"),
                    (false, Some(reason)) => format!("{title}: not feasible, {reason}"),
                    (false, None) => format!("{title}: not feasible"),
                });
            }
        }
        None
    }

    /// The state in one line.
    fn line(&self) -> String {
        let Self { counts, doing, .. } = self;
        if self.given {
            return doing.clone();
        }
        let waiting = self.drawn.saturating_sub(counts.tried);
        let waiting = match waiting {
            0 => String::new(),
            _ => format!(", {waiting} more drawn"),
        };
        let plans = match (self.first_after, self.best) {
            (Some(first), Some((cost, number))) => format!(
                ", {} plans, first after {first:.1} s, best {cost:.3} (sequence {number})",
                self.solutions
            ),
            _ => String::new(),
        };
        format!("{counts}{waiting}{plans} | {doing}")
    }
}

fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;
    use locotamp::Reached;

    #[test]
    fn the_line_counts_what_happened() {
        let mut progress = Progress::new(true);
        for number in 1..=3 {
            let labels = vec!["start".into(), "left_foot lifts".into()];
            progress.see(&Event::Sequence { number, labels });
            progress.see(&Event::Keyframes {
                number,
                possible: number == 3,
                reason: None,
            });
            if number != 3 {
                let reached = Reached::Keyframes;
                progress.see(&Event::Tried { number, reached });
            }
        }
        progress.see(&Event::Iteration {
            number: 3,
            iteration: 7,
            violation: 0.012,
            objective: 4.5,
        });
        let line = progress.line();
        assert!(
            line.starts_with("2 sequences tried (2 without keyframes), 1 more drawn | "),
            "{line}"
        );
        assert!(
            line.ends_with("sequence 3, iteration 7: violation 1.2e-2, cost 4.500"),
            "{line}"
        );
    }

    #[test]
    fn a_failed_optimisation_is_told_with_its_reason() {
        let reason = Some("torque of left_knee_joint: 3.00e0 N·m off, in phase 2".to_owned());
        let event = Event::Optimised {
            number: 4,
            feasible: false,
            cost: 1.0,
            reason,
        };
        let news = Progress::new(true).note(&event).unwrap();
        assert_eq!(
            news,
            "sequence 4: not feasible, torque of left_knee_joint: 3.00e0 N·m off, in phase 2"
        );
    }
}
