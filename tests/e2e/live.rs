//! A run that is shown while it goes on: frames arrive, whoever watches may come, go and freeze, and nothing changes.

mod support;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use support::Program;

/// Frame types of HTTP/2, RFC 9113 section 6.
const DATA: u8 = 0;
const HEADERS: u8 = 1;
const SETTINGS: u8 = 4;
const WINDOW_UPDATE: u8 = 8;
const ACK: u8 = 1;
const END_STREAM: u8 = 1;
/// Largest window, section 6.9.1.
const WINDOW: u32 = (1 << 31) - 1;

/// What a watcher has seen on one connection.
#[derive(Debug, Default)]
struct Seen {
    /// Whole messages of the stream, gRPC's frames of five bytes and a payload.
    messages: usize,
    bytes: usize,
    /// Whether the sender ended the stream by itself.
    ended: bool,
}

fn frame(kind: u8, flags: u8, stream: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = (payload.len() as u32).to_be_bytes()[1..].to_vec();
    bytes.extend([kind, flags]);
    bytes.extend(stream.to_be_bytes());
    bytes.extend(payload);
    bytes
}

/// As much of a viewer as takes what is sent: an HTTP/2 server with endless windows. Leaves after `most` messages.
fn watch(mut peer: TcpStream, most: usize) -> std::io::Result<Seen> {
    let mut preface = [0; 24];
    peer.read_exact(&mut preface)?;
    // SETTINGS_INITIAL_WINDOW_SIZE, and the same for the connection beyond the 65 535 it begins with.
    let setting = [&4_u16.to_be_bytes()[..], &WINDOW.to_be_bytes()].concat();
    peer.write_all(&frame(SETTINGS, 0, 0, &setting))?;
    peer.write_all(&frame(WINDOW_UPDATE, 0, 0, &(WINDOW - 65_535).to_be_bytes()))?;
    let (mut seen, mut pending) = (Seen::default(), Vec::new());
    while seen.messages < most {
        let mut head = [0; 9];
        if peer.read_exact(&mut head).is_err() {
            break;
        }
        let mut payload = vec![0; u32::from_be_bytes([0, head[0], head[1], head[2]]) as usize];
        peer.read_exact(&mut payload)?;
        let stream = u32::from_be_bytes([head[5], head[6], head[7], head[8]]);
        match (head[3], head[4]) {
            (SETTINGS, flags) if flags & ACK == 0 => peer.write_all(&frame(SETTINGS, ACK, 0, &[]))?,
            (DATA, flags) => {
                pending.extend(&payload);
                seen.bytes += payload.len();
                while let Some(length) =
                    pending.get(1..5).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]]) as usize)
                {
                    if pending.len() < 5 + length {
                        break;
                    }
                    pending.drain(..5 + length);
                    seen.messages += 1;
                }
                if flags & END_STREAM != 0 {
                    seen.ended = true;
                    // `:status 200`, `content-type application/grpc`, `grpc-status 0`, RFC 7541.
                    let answer = b"\x88\x5f\x10application/grpc\x40\x0bgrpc-status\x010";
                    peer.write_all(&frame(HEADERS, 4 | END_STREAM, stream, answer))?;
                }
            }
            _ => {}
        }
    }
    Ok(seen)
}

/// Watchers that come one after the other, each for so many messages.
fn watchers(most: &'static [usize]) -> (String, Receiver<Seen>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("it has one");
    let (say, seen) = channel();
    std::thread::spawn(move || {
        let mut most = most.iter();
        let mut next = most.next();
        for peer in listener.incoming().flatten() {
            let Some(count) = next else { break };
            // A knock at the door to see whether somebody is there says nothing.
            let Ok(found) = watch(peer, *count) else { continue };
            next = most.next();
            let _ = say.send(found);
        }
    });
    (format!("--live={address}"), seen)
}

const FRAMES: [&str; 6] = ["--set", "clock.fps=50", "--set", "output.pictures=false", "--set", "output.splats=false"];

fn run(more: &[&str]) -> support::Run {
    let args: Vec<&str> = FRAMES.iter().chain(&["--set", "output.recording=false"]).chain(more).copied().collect();
    Program::built_in("ball-on-block", &args).finish().expect_code(0)
}

#[test]
fn watchers_come_and_go_and_the_state_is_the_same() {
    let alone = run(&[]);
    let (live, seen) = watchers(&[12, usize::MAX]);
    let watched = run(&[&live]);
    assert_eq!(alone.hash(), watched.hash());
    let wait = Duration::from_secs(5);
    let first = seen.recv_timeout(wait).expect("somebody watched");
    assert!(first.messages >= 12 && !first.ended, "{first:?}");
    // Who comes later is given everything, and then hears that it is over.
    let second = seen.recv_timeout(wait).expect("somebody watched again");
    assert!(second.messages >= 12 && second.ended, "{second:?}");
    eprintln!("alone {:?}, watched {:?}: {first:?}, {second:?}", alone.took, watched.took);
}

#[test]
fn a_frozen_watcher_does_not_hold_the_run() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    // Connections are accepted by the system and never read.
    let live = format!("--live={}", listener.local_addr().expect("it has one"));
    let frozen = run(&[&live]);
    assert_eq!(frozen.hash(), run(&[]).hash());
}

#[test]
fn a_scene_without_frames_cannot_be_shown() {
    let run = Program::built_in("oscillator", &["--live=127.0.0.1:9"]).finish().expect_code(2);
    assert!(run.stderr.contains("clock.fps=24"), "{}", run.stderr);
}
