"""A link between master and slave that delays every byte by the same time. It loses nothing until it is cut."""
import queue
import socket
import threading
import time


class DelayedLink:
    """Listens on a free port and forwards to `target` (HOST:PORT) with `delay` [s] in each direction.

    After `max_down` bytes to the clients everything is lost, as by an unplugged cable: neither side is notified.
    """

    def __init__(self, target, delay, max_down=float("inf")):
        host, port = target.rsplit(":", 1)
        self.target, self.delay, self.max_down = (host, int(port)), delay, max_down
        self.bytes_down = 0  # bytes sent to clients

    def __enter__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.sockets = [self.listener]
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *error):
        for each in self.sockets:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            each.close()

    def cut(self):
        """Closes all connections. New ones are accepted."""
        for each in self.sockets[1:]:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def _accept(self):
        try:
            while True:
                near, _ = self.listener.accept()
                try:
                    far = socket.create_connection(self.target)
                except OSError:  # the target does not listen at present
                    near.close()
                    continue
                self.sockets += [near, far]
                for end in near, far:
                    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._carry(near, far, up=True)
                self._carry(far, near, up=False)
        except OSError:
            pass

    def _carry(self, source, sink, up):
        waiting = queue.Queue()
        threading.Thread(target=self._receive, args=(source, waiting, up), daemon=True).start()
        threading.Thread(target=self._send, args=(sink, waiting), daemon=True).start()

    def _receive(self, source, waiting, up):
        try:
            while data := source.recv(1 << 16):
                if self.bytes_down > self.max_down:
                    continue
                waiting.put((time.monotonic() + self.delay, data))
                self.bytes_down += 0 if up else len(data)
        except OSError:
            pass
        waiting.put((time.monotonic() + self.delay, b""))

    @staticmethod
    def _send(sink, waiting):
        try:
            while True:
                due, data = waiting.get()
                time.sleep(max(0.0, due - time.monotonic()))
                if not data:
                    sink.shutdown(socket.SHUT_WR)
                    return
                sink.sendall(data)
        except OSError:
            pass
