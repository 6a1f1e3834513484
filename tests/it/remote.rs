//! Rasters on another machine, which here is a server on loopback.

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use gdal::{Dataset, DriverManager};

use crate::util::{Dem, Folder, Kind, terrabite, terrabite_in_environment};

/// Serves one file, as a whole or in ranges, under the name dem.tif, until the test program ends.
struct Server {
    url: String,
    state: Arc<State>,
}

#[derive(Default)]
struct State {
    file: Vec<u8>,
    /// Another file that is there instead, from the request of this number on.
    later: Option<(u64, Vec<u8>)>,
    /// Every request of a multiple of this number is answered by 503.
    fails: Option<u64>,
    requests: AtomicU64,
    /// Bytes of the file that were sent.
    sent: AtomicU64,
}

impl Server {
    fn start(state: State) -> Server {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("/vsicurl/http://{}/dem.tif", listener.local_addr().unwrap());
        let state = Arc::new(state);
        let serving = Arc::clone(&state);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let serving = Arc::clone(&serving);
                std::thread::spawn(move || serving.answer(stream));
            }
        });
        Server { url, state }
    }

    fn of(path: &str) -> Server {
        Server::start(State { file: fs::read(path).unwrap(), ..State::default() })
    }

    /// The bytes that were sent since the last time.
    fn sent(&self) -> u64 {
        self.state.sent.swap(0, Ordering::Relaxed)
    }
}

/// Whether this GDAL knows servers.
fn has_servers() -> bool {
    let refused = terrabite(["info", "/vsicurl/http://127.0.0.1:1/dem.tif"]).fails(1, &[]);
    let has_servers = !refused.err.contains("not recognized");
    if !has_servers {
        eprintln!("skipped: this GDAL knows no servers");
    }
    has_servers
}

impl State {
    /// Answers one request.
    fn answer(&self, mut stream: TcpStream) {
        let mut request = [0; 4096];
        let length = stream.read(&mut request).unwrap_or(0);
        let request = String::from_utf8_lossy(&request[..length]).into_owned();
        let number = self.requests.fetch_add(1, Ordering::Relaxed) + 1;
        let bytes = self.later.as_ref().filter(|(first, _)| number >= *first).map_or(&self.file, |(_, bytes)| bytes);
        let (status, part) = match (request.contains("/dem.tif "), asked(&request, bytes.len())) {
            _ if self.fails.is_some_and(|every| number.is_multiple_of(every)) => {
                ("503 Service Unavailable".to_string(), 0..0)
            }
            (false, _) => ("404 Not Found".to_string(), 0..0),
            (true, None) => ("200 OK".to_string(), 0..bytes.len()),
            (true, Some(r)) if r.start >= bytes.len() => ("416 Range Not Satisfiable".to_string(), 0..0),
            (true, Some(r)) => {
                let of = format!("Content-Range: bytes {}-{}/{}", r.start, r.end - 1, bytes.len());
                (format!("206 Partial Content\r\n{of}"), r)
            }
        };
        let length = part.len();
        let header = format!(
            "HTTP/1.1 {status}\r\nContent-Length: {length}\r\nAccept-Ranges: bytes\r\nConnection: close\r\n\r\n"
        );
        // A client that has seen enough is nobody's failure.
        let _ = stream.write_all(header.as_bytes());
        if !request.starts_with("HEAD") {
            self.sent.fetch_add(length as u64, Ordering::Relaxed);
            let _ = stream.write_all(&bytes[part]);
        }
    }
}

/// The range that is asked for, of so many bytes.
fn asked(request: &str, bytes: usize) -> Option<Range<usize>> {
    let range = request.lines().find_map(|l| l.strip_prefix("Range: bytes="))?;
    let (first, last) = range.trim().split_once('-')?;
    let first: usize = first.parse().ok()?;
    Some(first..last.parse().map_or(bytes, |last: usize| (last + 1).min(bytes)))
}

#[test]
fn archives_and_servers() {
    let folder = Folder::new();
    let base = Dem::new(30, 20).on_the_map().write(&folder, "base.tif");
    let driver = DriverManager::get_driver_by_name("AAIGrid").unwrap();
    // Written through GDAL into the archive.
    let inside = format!("/vsizip/{}/dem.asc", folder.at("dems.zip"));
    let copy = Dataset::open(&base).unwrap().create_copy(&driver, &inside, &Default::default());
    copy.unwrap().close().unwrap();
    let tin = folder.at("tin.ply");
    terrabite(["simplify", &inside, &tin, "--max-error", "2"]).succeeds();
    terrabite(["verify", &inside, &tin, "--max-error", "2", "--window", "0,0,30,20"]).succeeds();
    if !has_servers() {
        return;
    }
    let Server { url, .. } = Server::of(&base);
    terrabite(["simplify", &url, &tin, "--max-error", "2", "--overwrite", "-q"]).succeeds();
    terrabite(["verify", &url, &tin, "--max-error", "2"]).succeeds();
    let missing = url.replace("dem.tif", "none.tif");
    terrabite(["info", &missing]).fails(1, &["none.tif", "cannot be opened as a raster"]);
}

/// A server that is busy now and then is asked again; one whose file changes meanwhile is noticed, though GDAL keeps what it has
/// fetched.
#[test]
fn servers_that_fail_now_and_then_or_change_their_file() {
    if !has_servers() {
        return;
    }
    let folder = Folder::new();
    let dem = |name: &str, heights| Dem::new(300, 200).tiled(64).heights(heights).write(&folder, name);
    let (one, other) = (dem("one.tif", |c, r| ((c * r) % 90) as f64), dem("other.tif", |c, r| ((c + r) % 90) as f64));
    let [one, other] = [one, other].map(|path| fs::read(path).unwrap());
    assert_eq!(one.len(), other.len());
    let tin = folder.at("tin.ply");
    let simplify = |server: &Server, retries: &str| {
        let variables = [("GDAL_HTTP_RETRY_DELAY", "0.01"), ("GDAL_HTTP_MAX_RETRY", retries)];
        let said = if retries.is_empty() { &variables[..1] } else { &variables };
        terrabite_in_environment(said, ["simplify", &server.url, &tin, "--max-error", "2", "--overwrite", "-q"])
    };
    let good = Server::start(State { file: one.clone(), ..State::default() });
    simplify(&good, "").succeeds();
    let expected = fs::read(&tin).unwrap();
    let busy = |fails| Server::start(State { file: one.clone(), fails: Some(fails), ..State::default() });
    simplify(&busy(3), "").succeeds();
    assert!(mesh(&fs::read(&tin).unwrap()) == mesh(&expected));
    let without = busy(2);
    simplify(&without, "0").fails(1, &[&without.url]);
    let last = good.state.requests.load(Ordering::Relaxed);
    for first in [last / 2, last - 4] {
        let changing =
            Server::start(State { file: one.clone(), later: Some((first, other.clone())), ..State::default() });
        let run = simplify(&changing, "");
        assert!(run.code == Some(1) && run.err.contains("changed"), "{run:?} from request {first} of {last} on");
    }
    assert!(mesh(&fs::read(&tin).unwrap()) == mesh(&expected));
}

/// A mesh without its header, which names the raster.
fn mesh(ply: &[u8]) -> &[u8] {
    let end = b"end_header\n";
    let at = ply.windows(end.len()).position(|bytes| bytes == end).unwrap();
    &ply[at..]
}

/// Each process fetches the part that its tiles need.
#[test]
fn shards_share_the_fetching() {
    if !has_servers() {
        return;
    }
    let folder = Folder::new();
    // Eight rows of tiles, and a unit of decoding for each second one.
    let dem = Dem::new(512, 4096).kind(Kind::Float64).tiled(256).heights(|c, r| ((c * c + 3 * r) % 500) as f64);
    let path = dem.write(&folder, "dem.tif");
    let server = Server::of(&path);
    let options = ["--max-error", "200", "--quality", "none"];
    let (whole, tin, work) = (folder.at("whole.ply"), folder.at("tin.ply"), folder.at("work"));
    terrabite([["simplify", &server.url, &whole].as_slice(), &options].concat()).succeeds();
    let once = server.sent();
    terrabite([["plan", &server.url, &work].as_slice(), &options].concat()).succeeds();
    server.sent();
    let shards: Vec<u64> = (1..=4)
        .map(|shard| {
            terrabite(["run", &work, "--shard", &format!("{shard}/4")]).succeeds();
            server.sent()
        })
        .collect();
    assert!(shards.iter().all(|sent| *sent < once * 7 / 10), "{shards:?} of {once}");
    terrabite(["merge", &work, &tin]).succeeds();
    assert!(fs::read(&tin).unwrap() == fs::read(&whole).unwrap());
    assert!(!Path::new(&work).exists());
}
