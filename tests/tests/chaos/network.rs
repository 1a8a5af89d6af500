//! Network namespaces: every process of the farm has a machine's network of its own,
//! with one cable to this one. Packets are lost and cables are pulled there; what TCP
//! would mend (damage, repetition, order of messages) is the part of [`super::line`].

use std::ffi::OsStr;
use std::io::Write;
use std::net::Ipv4Addr;
use std::process::{Command, Stdio};

/// Blocks of eight networks of four addresses.
const BLOCKS: u8 = 8;

/// How packets fare on a cable, both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cable {
    /// They arrive.
    Good,
    /// It is pulled: packets vanish, nobody is told.
    Pulled,
    /// One in so many is lost, at random.
    Lossy { one_in: u32 },
    /// No more than this passes; what does not fit is dropped.
    Narrow { kbit_s: u32 },
}

/// A namespace, its cable, and its two addresses; gone when dropped.
#[derive(Debug)]
pub(crate) struct Room {
    name: String,
    /// This side of the cable.
    pub(crate) gateway: Ipv4Addr,
    /// That of whoever lives there.
    pub(crate) address: Ipv4Addr,
}

/// So many rooms, or why there are none: only root may make them.
pub(crate) fn rooms(number: usize) -> Result<Vec<Room>, String> {
    // Tests of one machine, at the same time: by process and a third byte of its own.
    let third = std::process::id() % 250;
    (0..number)
        .map(|n| Room::new(third as u8, u8::try_from(n).map_err(|e| e.to_string())?))
        .collect()
}

impl Room {
    fn new(third: u8, number: u8) -> Result<Self, String> {
        // Two pairs of stores may be tested at once: each takes the next free block.
        let mut why = String::new();
        for block in 0..BLOCKS {
            let base = block * 32 + number * 4;
            let name = format!("sw{third}n{base}");
            if let Err(error) = run("ip", &["netns", "add", &name]) {
                why = error;
                continue;
            }
            let room = Self {
                name,
                gateway: Ipv4Addr::new(10, 213, third, base + 1),
                address: Ipv4Addr::new(10, 213, third, base + 2),
            };
            return room.wire().map(|()| room);
        }
        Err(why)
    }

    fn cable(&self) -> &str {
        &self.name
    }

    fn wire(&self) -> Result<(), String> {
        let (name, cable) = (self.name.as_str(), self.cable());
        let (gateway, address) = (
            format!("{}/30", self.gateway),
            format!("{}/30", self.address),
        );
        for args in [
            &[
                "link", "add", cable, "type", "veth", "peer", "name", "eth0", "netns", name,
            ][..],
            &["addr", "add", &gateway, "dev", cable],
            &["link", "set", cable, "up"],
            &["-n", name, "addr", "add", &address, "dev", "eth0"],
            &["-n", name, "link", "set", "eth0", "up"],
            &["-n", name, "link", "set", "lo", "up"],
        ] {
            run("ip", args)?;
        }
        // What is asked of the cable later must be possible now.
        for state in [
            Cable::Lossy { one_in: 2 },
            Cable::Narrow { kbit_s: 1000 },
            Cable::Good,
        ] {
            self.becomes(state)?;
        }
        Ok(())
    }

    /// Change the cable.
    pub(crate) fn becomes(&self, state: Cable) -> Result<(), String> {
        let (name, cable) = (self.name.as_str(), self.cable());
        let loss = match state {
            Cable::Lossy { one_in } => format!("numgen random mod {one_in} == 0 drop"),
            _ => String::new(),
        };
        // Declared first, so that it can be deleted whether it was there or not.
        let rules = format!(
            "table inet chaos {{ }}\ndelete table inet chaos\ntable inet chaos {{\n\
             chain in {{\ntype filter hook input priority 0\n{loss}\n}}\n\
             chain out {{\ntype filter hook output priority 0\n{loss}\n}}\n}}\n"
        );
        feed("ip", &["netns", "exec", name, "nft", "-f", "-"], &rules)?;
        for (place, dev) in [(&[][..], cable), (&["-n", name], "eth0")] {
            match state {
                Cable::Narrow { kbit_s } => {
                    let rate = format!("{kbit_s}kbit");
                    let args = [
                        "qdisc", "replace", "dev", dev, "root", "tbf", "rate", &rate, "burst",
                        "32kb", "latency", "200ms",
                    ];
                    run("tc", &[place, &args].concat())?;
                }
                // It may not be narrow now.
                _ => drop(run(
                    "tc",
                    &[place, &["qdisc", "del", "dev", dev, "root"]].concat(),
                )),
            }
        }
        let up = if state == Cable::Pulled { "down" } else { "up" };
        run("ip", &["link", "set", cable, up])
    }

    /// A command that runs there, as the same process.
    pub(crate) fn command(&self, command: &Command) -> Command {
        let mut inside = Command::new("ip");
        inside.args(["netns", "exec", &self.name]);
        inside.arg(command.get_program()).args(command.get_args());
        for (name, value) in command.get_envs() {
            match value {
                Some(value) => inside.env(name, value),
                None => inside.env_remove(name),
            };
        }
        inside
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        // The cable first: a namespace lives as long as a process in it.
        let _ = run("ip", &["link", "del", self.cable()]);
        let _ = run("ip", &["netns", "del", &self.name]);
    }
}

fn run(program: &str, args: &[&str]) -> Result<(), String> {
    feed(program, args, "")
}

fn feed<S: AsRef<OsStr>>(program: &str, args: &[S], text: &str) -> Result<(), String> {
    let child = Command::new(program)
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = child.map_err(|e| format!("{program}: {e}"))?;
    if let Some(mut input) = child.stdin.take() {
        // It may have ended already; its exit code says why.
        let _ = input.write_all(text.as_bytes());
    }
    let output = child.wait_with_output().map_err(|e| e.to_string())?;
    if output.status.success() {
        return Ok(());
    }
    let args: Vec<_> = args.iter().map(|arg| arg.as_ref().display()).collect();
    let args: Vec<_> = args.iter().map(ToString::to_string).collect();
    let why = String::from_utf8_lossy(&output.stderr);
    Err(format!("{program} {}: {}", args.join(" "), why.trim()))
}
