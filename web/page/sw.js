// Keeps the page for use without a network. scripts/web.sh fills in VERSION and FILES.
const VERSION = 'VERSION_OF_FILES';
const FILES = LIST_OF_FILES;

addEventListener('install', event => {
  event.waitUntil(caches.open(VERSION).then(cache => cache.addAll(FILES)).then(() => skipWaiting()));
});

addEventListener('activate', event => {
  const old = names => names.filter(name => name !== VERSION).map(name => caches.delete(name));
  event.waitUntil(caches.keys().then(names => Promise.all(old(names))).then(() => clients.claim()));
});

addEventListener('fetch', event => {
  const kept = caches.match(event.request, { ignoreSearch: true });
  event.respondWith(kept.then(answer => answer ?? fetch(event.request)));
});
