//! Orders from lines of text: a thread reads them and hands them to the loops through queues without locks.

use std::io::BufRead;
use std::thread::{Builder, JoinHandle, sleep};
use std::time::Duration;

use rtrb::{Consumer, Producer, PushError, RingBuffer};

use super::Order;

/// Orders that wait for a loop.
const CAPACITY: usize = 64;
/// The longest line that is looked at, in bytes; a longer one is no order.
const LONGEST: usize = 256;
/// From one look to the next whether a loop has taken orders.
const REST: Duration = Duration::from_millis(1);

/// Reads orders from `lines`, one per line, on a thread of its own, until they end. One queue for each of `N` sides: a line
/// may begin with the number of the side that it is for, from 1; without a number it is for all. Nothing waits for the
/// thread; it ends with the program.
///
/// # Errors
///
/// That of the operating system if it gives no thread.
pub fn listen<const N: usize>(
    lines: impl BufRead + Send + 'static,
) -> std::io::Result<(JoinHandle<()>, [Consumer<Order>; N])> {
    let mut producers = Vec::with_capacity(N);
    let consumers = [(); N].map(|()| {
        let (producer, consumer) = RingBuffer::new(CAPACITY);
        producers.push(producer);
        consumer
    });
    let thread = Builder::new().name("console".to_owned()).spawn(move || read(lines, &mut producers))?;
    Ok((thread, consumers))
}

/// Reads lines until they end.
fn read(mut lines: impl BufRead, sides: &mut [Producer<Order>]) {
    let mut line = Vec::with_capacity(LONGEST);
    loop {
        line.clear();
        match take_line(&mut lines, &mut line) {
            Ok(true) => {}
            Ok(false) | Err(_) => return,
        }
        let text = if line.len() < LONGEST { std::str::from_utf8(&line).unwrap_or("?") } else { "?" };
        if text.trim().is_empty() {
            continue;
        }
        let (only, order) = addressed(text.trim(), sides.len());
        for (side, queue) in (1..).zip(sides.iter_mut()) {
            if only.is_none_or(|only| only == side) {
                hand_over(queue, order);
            }
        }
    }
}

/// Waits for room, so that no order is lost behind many others; gives up once the loop has ended.
fn hand_over(queue: &mut Producer<Order>, mut order: Order) {
    while let Err(PushError::Full(again)) = queue.push(order) {
        if queue.is_abandoned() {
            return;
        }
        order = again;
        sleep(REST);
    }
}

/// Takes the next line, and keeps its first bytes only; false at the end.
fn take_line(lines: &mut impl BufRead, line: &mut Vec<u8>) -> std::io::Result<bool> {
    let mut has_any = false;
    loop {
        let piece = match lines.fill_buf() {
            Ok(piece) => piece,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        if piece.is_empty() {
            return Ok(has_any);
        }
        has_any = true;
        let end = piece.iter().position(|byte| *byte == b'\n');
        let length = end.unwrap_or(piece.len());
        let room = LONGEST.saturating_sub(line.len()).min(length);
        line.extend_from_slice(piece.get(..room).unwrap_or_default());
        let taken = end.map_or(length, |end| end + 1);
        lines.consume(taken);
        if end.is_some() {
            return Ok(true);
        }
    }
}

/// The side that a line is for, if it names one of `sides`, and its order.
fn addressed(line: &str, sides: usize) -> (Option<usize>, Order) {
    let named = line.split_once(char::is_whitespace).and_then(|(first, rest)| {
        let side = first.parse().ok().filter(|side| (1..=sides).contains(side))?;
        Some((side, rest))
    });
    match named {
        Some((side, rest)) if sides > 1 => (Some(side), Order::parse(rest)),
        _ => (None, Order::parse(line)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::MarkKind;

    fn orders<const N: usize>(text: &[u8]) -> [Vec<Order>; N] {
        let (thread, mut consumers) = listen::<N>(std::io::Cursor::new(text.to_vec())).unwrap();
        let mut all = [(); N].map(|()| Vec::new());
        loop {
            let is_over = thread.is_finished();
            for (orders, consumer) in all.iter_mut().zip(&mut consumers) {
                orders.extend(std::iter::from_fn(|| consumer.pop().ok()));
            }
            if is_over {
                return all;
            }
        }
    }

    #[test]
    fn law_a_line_speaks_to_the_side_that_it_names_or_to_all() {
        let [first, second] = orders(b"1 consent\n\n2 pause\r\nstop\n3 clear\n2 mark trial 2\nresume");
        assert_eq!(first, [Order::Consent, Order::Stop, Order::unknown("3 clear"), Order::Resume]);
        let [pause, stop, unknown, Order::Mark(mark), resume] = second[..] else { panic!("{second:?}") };
        assert_eq!(
            [pause, stop, unknown, resume],
            [Order::Pause, Order::Stop, Order::unknown("3 clear"), Order::Resume]
        );
        assert_eq!((mark.kind, mark.label.text()), (MarkKind::Trial, "2"));
        // a single site has no numbers
        let [only] = orders(b"1 consent\nconsent\n");
        assert_eq!(only, [Order::unknown("1 consent"), Order::Consent]);
    }

    #[test]
    fn law_a_line_without_an_end_takes_no_memory_and_is_no_order() {
        let mut text = vec![b'x'; 1 << 20];
        text.extend_from_slice(b"\n\xff\xfe\nconsent\n");
        let [only] = orders(&text);
        assert_eq!(only, [Order::unknown("?"), Order::unknown("?"), Order::Consent]);
    }

    #[test]
    fn law_no_order_is_lost_behind_many_others_and_nobody_waits_for_a_loop_that_has_ended() {
        let text = "mark note 7\n".repeat(1000) + "stop\n";
        let [many] = orders(text.as_bytes());
        assert_eq!((many.len(), many.last()), (1001, Some(&Order::Stop)));
        let (thread, [consumer]) = listen::<1>(std::io::Cursor::new(text.into_bytes())).unwrap();
        drop(consumer);
        thread.join().unwrap();
    }
}
