//! `view`: a mesh in the browser.

mod serve;

use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::process::ExitCode;

use super::progress::Bars;
use super::{Failure, output_format, print, signals};
use crate::formats;
use crate::page;
use crate::run::scene::{Most, SceneRequest, read};
use serve::Server;

/// Show a mesh in the browser, to be turned and looked at closely
///
/// A page with the mesh is served on this machine only (127.0.0.1), until Ctrl-C ends it; its address is printed. It has no
/// content but what is in the mesh. On a machine without a screen: open the address at home, with the port forwarded by
/// ssh -L PORT:127.0.0.1:PORT HOST.
#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The mesh, in any of the formats
    mesh: PathBuf,
    /// The format of the mesh, whatever it is called [default: what its content and its extension say]
    #[arg(long, value_parser = output_format::names(output_format::MESHES))]
    format: Option<String>,
    /// Show at most so many triangles; of a larger mesh, a copy made by meshoptimizer, which the page says
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1000..=10_000_000))]
    triangles: u32,
    /// The port to listen on [default: one that is free]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Do not open a browser. Without a screen none is opened anyway
    #[arg(long)]
    no_open: bool,
    /// The folder of temporary files [default: the system's]
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Print nothing but the address, and errors
    #[arg(long, short)]
    pub(super) quiet: bool,
}

pub(crate) fn run(args: &ViewArgs) -> Result<ExitCode, Failure> {
    let triangles = args.triangles as usize;
    let request = SceneRequest {
        mesh: args.mesh.clone(),
        format: args.format.as_deref().and_then(formats::by_name),
        most: Most { whole: triangles, copy: triangles },
        temp_dir: args.temp_dir.clone(),
    };
    // A port that is taken is told of before the work begins.
    let server = Server::bind(args.port)?;
    let bars = Bars::new(args.quiet);
    let report = read(&request, &bars.control())?;
    drop(bars);
    let page = page::of_mesh(&report, &args.mesh, args.temp_dir.as_deref())?;
    drop(report);
    let address = server.address();
    print::report(&address)?;
    if !args.quiet {
        print::error(&hint(server.port()));
    }
    if !args.no_open && has_screen() {
        // Where no browser can be found the address is there.
        let _ = open::that_detached(&address);
    }
    server.serve(page, &signals::token())?;
    Ok(ExitCode::SUCCESS)
}

/// What to do with the address.
fn hint(port: u16) -> String {
    let end = "Ctrl-C ends it";
    match std::env::var_os("SSH_CONNECTION") {
        None => end.to_string(),
        Some(_) => format!(
            "from the machine that you sit at: ssh -L {port}:{}:{port} THIS_HOST, then open the address there; {end}",
            Ipv4Addr::LOCALHOST
        ),
    }
}

/// Whether a browser would have where to show itself.
fn has_screen() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(target_os = "macos") || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}
