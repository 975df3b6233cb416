//! `locotamp watch`: the page of a run, served on this machine alone while the search goes on.

use crate::failure::Failure;
use crate::{Exit, output};
use clap::Args;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;
use view::Run;

/// A browser that says nothing for so long is not waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// Requests are shorter than this [bytes].
const LONGEST_REQUEST: u64 = 16 * 1024;

#[derive(Debug, Args)]
pub(crate) struct WatchOptions {
    /// Folder of a run of `locotamp plan`
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Port on 127.0.0.1; 0: any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
}

/// Serves the page until it is interrupted.
pub(crate) fn run(options: &WatchOptions) -> Result<Exit, Failure> {
    let run = Run::open(&options.folder).map_err(|error| Failure::new(Exit::BadInput, error))?;
    let listener = listen(options.port)?;
    let address = listener
        .local_addr()
        .map_err(|error| Failure::new(Exit::BadInput, error))?;
    output::result(&format!("http://{address}\n"));
    serve(&listener, &run);
    Ok(Exit::Done)
}

/// Serves the page of a run in a thread of its own, which ends with the program; its address.
pub(crate) fn beside(folder: &Path) -> Result<String, Failure> {
    let run = Run::open(folder).map_err(|error| Failure::new(Exit::BadInput, error))?;
    let listener = listen(0)?;
    let address = listener
        .local_addr()
        .map_err(|error| Failure::new(Exit::BadInput, error))?;
    thread::spawn(move || serve(&listener, &run));
    Ok(format!("http://{address}"))
}

/// A port of this machine that no other machine reaches.
fn listen(port: u16) -> Result<TcpListener, Failure> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| {
        Failure::new(
            Exit::BadInput,
            format_args!(
                "cannot listen on 127.0.0.1:{port}: {error}; choose another --port, or 0 for any"
            ),
        )
    })
}

/// Answers one browser after the other.
fn serve(listener: &TcpListener, run: &Run) {
    for stream in listener.incoming().flatten() {
        // A browser that goes away in the middle of an answer is its own affair.
        let _ = answer(stream, run);
    }
}

fn answer(mut stream: TcpStream, run: &Run) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new(stream.try_clone()?.take(LONGEST_REQUEST)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    let mut host = String::new();
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            value.trim().clone_into(&mut host);
        }
    }
    let reply = reply(&request, &host, run);
    stream.write_all(reply.as_bytes())
}

/// The whole answer to a request. Only pages that came from here may ask: another site's script that had its own name
/// point to this machine would give itself away by the host.
fn reply(request: &str, host: &str, run: &Run) -> String {
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    if !["127.0.0.1", "localhost"].contains(&name) {
        return response("403 Forbidden", "text/plain", "ask for http://127.0.0.1");
    }
    let mut words = request.split(' ');
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    if method != "GET" {
        return response("405 Method Not Allowed", "text/plain", "only GET");
    }
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let made = match path {
        "/" => run
            .page(true)
            .map(|text| response("200 OK", "text/html; charset=utf-8", &text)),
        "/data.json" if query.strip_prefix("revision=") == Some(&run.revision()) => {
            Ok(response("204 No Content", "application/json", ""))
        }
        "/data.json" => run
            .data(true)
            .map(|text| response("200 OK", "application/json", &text)),
        _ => Ok(response(
            "404 Not Found",
            "text/plain",
            "there is only the page",
        )),
    };
    made.unwrap_or_else(|error| {
        response(
            "500 Internal Server Error",
            "text/plain",
            &error.to_string(),
        )
    })
}

fn response(status: &str, kind: &str, body: &str) -> String {
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n{body}",
        body.len()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn there_is_the_page_and_its_data_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let journal = folder.path().join("journal.jsonl");
        fs::write(&journal, "{\"kind\":\"run\",\"scene\":\"here\"}\n").unwrap();
        let run = Run::open(folder.path()).unwrap();
        let host = "127.0.0.1:8000";
        let get = |target: &str| reply(&format!("GET {target} HTTP/1.1"), host, &run);
        assert!(get("/").starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html"));
        assert!(get("/").contains("connect-src 'self'"));
        assert!(get("/data.json").contains("\"scene\":\"here\""));
        let same = format!("/data.json?revision={}", run.revision());
        assert!(get(&same).starts_with("HTTP/1.1 204"));
        fs::write(&journal, "{\"kind\":\"run\",\"scene\":\"there\"}\n").unwrap();
        assert!(get(&same).contains("\"scene\":\"there\""));
        for other in ["/journal.jsonl", "/../secret", "//data.json", ""] {
            assert!(get(other).starts_with("HTTP/1.1 404"), "{other}");
        }
        assert!(reply("POST / HTTP/1.1", host, &run).starts_with("HTTP/1.1 405"));
        for stranger in [
            "",
            "evil.example",
            "evil.example:80",
            "127.0.0.1.evil.example",
        ] {
            assert!(
                reply("GET / HTTP/1.1", stranger, &run).starts_with("HTTP/1.1 403"),
                "{stranger}"
            );
        }
    }

    #[test]
    fn the_port_is_one_of_this_machine_alone() {
        let listener = listen(0).unwrap();
        assert!(listener.local_addr().unwrap().ip().is_loopback());
        let taken = listener.local_addr().unwrap().port();
        assert!(
            listen(taken)
                .unwrap_err()
                .text()
                .contains("choose another --port")
        );
    }
}
