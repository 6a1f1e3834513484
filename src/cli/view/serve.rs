//! One page, on this machine only.

use std::fs::File;
use std::io::{self, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{
    CACHE_CONTROL, CONTENT_TYPE, HOST, HeaderValue, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};

use crate::base::control::CancelToken;
use crate::cli::Failure;

/// How often it is asked whether to end.
const PATIENCE: Duration = Duration::from_millis(100);

/// Listens on 127.0.0.1. The page's path cannot be guessed, since other users of the machine can reach the port; and the page is
/// given to nobody who calls this machine by another name than `localhost` or its address, as pages of others could make a browser
/// do.
pub(super) struct Server {
    listener: TcpListener,
    port: u16,
    path: String,
}

impl Server {
    /// Takes a port; any that is free for 0.
    pub(super) fn bind(port: u16) -> Result<Server, Failure> {
        let failed = |error: io::Error| {
            let failure = Failure::new(format!("127.0.0.1:{port}: {error}"));
            match error.kind() {
                io::ErrorKind::AddrInUse | io::ErrorKind::PermissionDenied => {
                    failure.hint("choose another --port, or none")
                }
                _ => failure,
            }
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let mut secret = [0; 8];
        File::open("/dev/urandom")
            .and_then(|mut random| random.read_exact(&mut secret))
            .map_err(|error| Failure::new(format!("/dev/urandom: {error}")))?;
        let path = secret.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        Ok(Server { listener, port, path: format!("/{path}/") })
    }

    pub(super) fn port(&self) -> u16 {
        self.port
    }

    /// Where the page is.
    pub(super) fn address(&self) -> String {
        format!("http://127.0.0.1:{}{}", self.port, self.path)
    }

    /// Serves the page until it is told to end.
    pub(super) fn serve(self, page: String, cancel: &CancelToken) -> Result<(), Failure> {
        let failed = |error: io::Error| Failure::new(format!("the page cannot be served: {error}"));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        let (path, page) = (self.path, Bytes::from(page));
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener).map_err(failed)?;
            while !cancel.is_cancelled() {
                let Ok(accepted) = tokio::time::timeout(PATIENCE, listener.accept()).await else { continue };
                // A connection that is gone already, or too many at once, is no reason to end.
                let Ok((stream, _)) = accepted else { continue };
                let (path, page) = (path.clone(), page.clone());
                let answer = service_fn(move |request: Request<Incoming>| {
                    let response = answer(&request, &path, &page);
                    async { Ok::<_, std::convert::Infallible>(response) }
                });
                tokio::spawn(async move {
                    // A browser that hangs up has what it wants.
                    let _ = http1::Builder::new()
                        .timer(TokioTimer::new())
                        .serve_connection(TokioIo::new(stream), answer)
                        .await;
                });
            }
            Ok(())
        })
    }
}

fn answer<B>(request: &Request<B>, path: &str, page: &Bytes) -> Response<Full<Bytes>> {
    let plain = |status: StatusCode| {
        let mut response = Response::new(Full::new(Bytes::from(format!("{status}\n"))));
        *response.status_mut() = status;
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
        response
    };
    let mut response = if !is_here(request.headers().get(HOST)) {
        plain(StatusCode::FORBIDDEN)
    } else if request.uri().path() != path {
        plain(StatusCode::NOT_FOUND)
    } else if *request.method() != Method::GET && *request.method() != Method::HEAD {
        plain(StatusCode::METHOD_NOT_ALLOWED)
    } else {
        let mut response = Response::new(Full::new(page.clone()));
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"));
        response
    };
    for (name, value) in [
        (CACHE_CONTROL, "no-store"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether a request names this machine as itself. The port may be another one: it is where ports are forwarded.
fn is_here(host: Option<&HeaderValue>) -> bool {
    let Some(host) = host.and_then(|host| host.to_str().ok()) else { return false };
    let name = host
        .rsplit_once(':')
        .filter(|(_, port)| port.bytes().all(|b| b.is_ascii_digit()))
        .map_or(host, |(name, _)| name);
    ["127.0.0.1", "localhost", "[::1]"].contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(method: Method, path: &str, host: &str) -> StatusCode {
        let request = Request::builder().method(method).uri(path).header(HOST, host).body(()).unwrap();
        answer(&request, "/0123/", &Bytes::from_static(b"page")).status()
    }

    #[test]
    fn there_is_one_page_for_those_who_know_where() {
        let here = "127.0.0.1:8000";
        for (path, expected) in
            [("/0123/", 200), ("/0123/?x", 200), ("/", 404), ("/0123", 404), ("/0123/../etc/passwd", 404)]
        {
            assert_eq!(asked(Method::GET, path, here), expected, "{path}");
        }
        assert_eq!(asked(Method::HEAD, "/0123/", here), 200);
        assert_eq!(asked(Method::POST, "/0123/", here), 405);
        for (host, expected) in [
            ("localhost", 200),
            ("localhost:1", 200),
            ("[::1]:80", 200),
            ("evil.example", 403),
            ("127.0.0.1.evil.example:8000", 403),
        ] {
            assert_eq!(asked(Method::GET, "/0123/", host), expected, "{host}");
        }
        assert!(!is_here(None));
    }
}
