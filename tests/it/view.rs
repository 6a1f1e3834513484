//! `view`: one page on this machine, and nothing else.

use std::io::{Read, Write};
use std::net::TcpStream;

use crate::util::{Dem, Folder, Served, flat, terrabite};

/// What a server answers to a request: its status and the rest.
fn asked(port: u16, request: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.write_all(request.replace('\n', "\r\n").as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    (answer.split(' ').nth(1).unwrap().parse().unwrap(), answer)
}

fn get(port: u16, path: &str, host: &str) -> (u16, String) {
    asked(port, &format!("GET {path} HTTP/1.1\nHost: {host}\nConnection: close\n\n"))
}

#[test]
fn one_page_and_nothing_else_until_it_is_told_to_end() {
    let folder = Folder::new();
    let dem = Dem::new(80, 60).on_the_map().write(&folder, "dem.tif");
    for name in ["tin.ply", "tin.glb", "tin.stl"] {
        let tin = folder.at(name);
        terrabite(["simplify", &dem, &tin, "--max-error", "3", "--quiet"]).succeeds();
        let names = folder.names();
        let served = Served::start(["view", &tin, "--no-open"]);
        let (port, path) = served.address();
        let (status, answer) = get(port, &path, "localhost");
        assert_eq!(status, 200);
        assert!(answer.contains("text/html") && answer.contains("All ") && answer.contains(name), "{name}");
        assert!(answer.contains("id=\"view-mesh\"") && answer.contains("script-src 'sha256-"));
        for (other, host, expected) in [
            ("/", "localhost", 404),
            ("/dem.tif", "localhost", 404),
            ("/../../etc/passwd", "localhost", 404),
            (path.as_str(), "terrain.example", 403),
        ] {
            let (status, answer) = get(port, other, host);
            assert!(status == expected && answer.len() < 600, "{other} {host}: {answer}");
        }
        assert_eq!(asked(port, "nonsense\n\n").0, 400);
        let ended = served.interrupted();
        assert_eq!((ended.code, ended.err.trim()), (Some(0), "Ctrl-C ends it"));
        assert!(TcpStream::connect(("127.0.0.1", port)).is_err());
        assert_eq!(folder.names(), names);
    }
}

#[test]
fn what_cannot_be_shown_is_told() {
    let folder = Folder::new();
    let tin = folder.with("tin.ply", flat(9, 9, 0.0));
    terrabite(["view", &folder.at("none.ply"), "--no-open"]).fails(1, &["none.ply"]);
    let text = folder.with("text.txt", "no mesh");
    terrabite(["view", &text, "--no-open"]).fails(1, &["text.txt", "PLY"]);
    terrabite(["view", &tin, "--no-open", "--triangles", "3"]).fails(2, &["--triangles"]);
    let served = Served::start(["view", &tin, "--no-open", "--quiet"]);
    let port = served.address().0.to_string();
    terrabite(["view", &tin, "--no-open", "--port", &port]).fails(1, &[&port, "--port"]);
    assert_eq!(served.interrupted().err, "");
}
