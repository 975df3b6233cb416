//! Benchmark of the plan search: `search_table RECORD.jsonl [--parts A,B] [--seeds N] [--variants N] [--only NAME]
//! [--time-limit S] [--threads N] [--list] [--print]`.
//!
//! Every run is one line of RECORD, appended when it ends; a run that is there already is not repeated. At the end, and
//! with `--print` alone, RECORD is printed as tables in Markdown.

mod arguments;
mod measure;
mod numbers;
mod record;
mod rows;
mod runs;
#[cfg(test)]
mod samples;
mod table;

use arguments::Arguments;
use record::Book;
use runs::Run;
use std::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let arguments = match Arguments::parse(&given) {
        Ok(arguments) => arguments,
        Err(message) => {
            eprintln!("{message}\n\n{}", arguments::USAGE);
            return ExitCode::from(2);
        }
    };
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut book = Book::open(&arguments.record, arguments.mode())?;
    let missing: Vec<Run> = runs::all(&arguments.extent)
        .into_iter()
        .filter(|run| arguments.wants(&run.name()) && !book.has(run))
        .collect();
    if arguments.list {
        for run in &missing {
            println!("{}", run.name());
        }
        return Ok(());
    }
    if !arguments.print {
        for (number, run) in (1..).zip(&missing) {
            eprintln!("{number}/{}: {}", missing.len(), run.name());
            let record = measure::measure(run, arguments.threads)?;
            eprintln!("  {}", table::line(&record));
            book.add(record)?;
        }
    }
    print!("{}", table::write(&book.records));
    Ok(())
}
